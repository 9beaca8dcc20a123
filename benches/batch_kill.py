#!/usr/bin/env python3
"""Kills batches at random moments and shows that nothing is lost.

    benches/batch_kill.py MICROTOME [--models 60] [--kills 20] [--seed 1] [--threads N] [--keep DIR] [-- FLAGS]

A folder of models, some of them broken, is sliced once undisturbed. Then the same batch is killed (SIGKILL)
again and again, the supervisor and single workers, and taken up with --resume until it is done. At every
death each visible output must be whole, and at the end all must be there with the same bytes and none be done
twice. After that the same with outputs harmed behind its back, on a disk that is full (a small tmpfs, where
we may mount one). FLAGS are for all batches but the first, such as, where the program was built with GPU
support, --backend auto --adapter llvmpipe --fault lost@5x3, with which devices are lost on the way.

Only Python's standard library is needed. Exit code 0 when everything held, 1 when something did not.
"""

import argparse
import collections
import json
import math
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STATE = ".microtome"
REPORTS = ("report.json", "report.csv", "report.html", "quarantine.jsonl")
# Deaths of the supervisor are no fault of the models here, so none is to be given up for them.
RETRIES = "100"


class Wrong(Exception):
    """Something did not hold."""


def check(holds, what):
    if not holds:
        raise Wrong(what)


# ---------------------------------------------------------------------------------------------- models


def ball(radius, around, up):
    """Facets of a ball that is cut into `around` x `up` patches."""

    def at(i, j):
        a, b = 2 * math.pi * (i % around) / around, math.pi * j / up
        return (radius * math.cos(a) * math.sin(b), radius * math.sin(a) * math.sin(b), -radius * math.cos(b))

    facets = []
    for j in range(up):
        for i in range(around):
            p, q, r, s = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            if j > 0:
                facets.append((p, q, r))
            if j < up - 1:
                facets.append((p, r, s))
    return facets


def stl(facets):
    out = bytearray(80) + struct.pack("<I", len(facets))
    for facet in facets:
        out += struct.pack("<12fH", 0, 0, 0, *(c for corner in facet for c in corner), 0)
    return bytes(out)


def make_models(folder, count, dice):
    """Models of mixed size, about one in twenty of them broken; the number of broken ones."""
    folder.mkdir()
    broken = 0
    for n in range(count):
        around = 4 + int(10 ** dice.uniform(0, 2.2))
        body = stl(ball(dice.uniform(3, 14), around, max(3, around // 2)))
        path = folder / f"m{n:04}.stl"
        kind = ("truncated", "text", "empty", "dangling")[n // 20 % 4] if n % 20 == 7 else "good"
        broken += kind != "good"
        if kind == "truncated":
            path.write_bytes(body[: len(body) // 2])
        elif kind == "text":
            path.write_bytes(b"this is no model\n" * 20)
        elif kind == "empty":
            path.write_bytes(b"")
        elif kind == "dangling":
            path.symlink_to(folder / "nowhere.stl")
        else:
            path.write_bytes(body)
    # A folder where a file should be, which not even root can read.
    (folder / "folder.stl").mkdir()
    (folder / "jobs.jsonl").write_text(json.dumps({"model": "folder.stl"}) + "\n")
    return broken + 1


# ---------------------------------------------------------------------------------------------- running


class Batch:
    """One way to start the batch."""

    def __init__(self, program, models, flags):
        self.command = [str(program), "batch", str(models), str(models / "jobs.jsonl"), "--retries", RETRIES]
        self.flags = flags

    def start(self, out, *more):
        return subprocess.Popen(
            [*self.command, "-o", str(out), "--resume", *more, *self.flags],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
            env={**os.environ, "SOURCE_DATE_EPOCH": "0"},
        )

    def finish(self, out, *more):
        """Runs to the end; exit code and what it said."""
        process = self.start(out, *more)
        said = process.communicate()[1].decode(errors="replace")
        return process.returncode, said


def stat_of(pid):
    """State, parent and session of a process, or None."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return None
    fields = text.rsplit(")", 1)[1].split()
    return fields[0], int(fields[1]), int(fields[3])


def members(session):
    """Living processes of a session but its leader."""
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit() and int(entry) != session:
            stat = stat_of(entry)
            if stat and stat[2] == session and stat[0] != "Z":
                found.append(int(entry))
    return found


def wait_for_orphans(session):
    end = time.monotonic() + 60
    while members(session):
        check(time.monotonic() < end, "workers live on a minute after their supervisor was killed")
        time.sleep(0.01)


# ---------------------------------------------------------------------------------------------- looking


def outputs(folder):
    """All files by their path in the folder, but for reports and the state."""
    found = {}
    for base, folders, files in os.walk(folder):
        if base == str(folder):
            folders[:] = [name for name in folders if name != STATE]
        for name in files:
            path = Path(base) / name
            relative = str(path.relative_to(folder))
            if relative not in REPORTS:
                found[relative] = path
    return found


def is_leftover(name):
    return Path(name).name.startswith(".")


def compare(out, reference, whole):
    """Every visible output is that of the undisturbed run, byte for byte; how many there are."""
    ours, theirs = outputs(out), outputs(reference)
    visible = {name for name in ours if not is_leftover(name)}
    check(visible <= set(theirs), f"outputs that nobody asked for: {sorted(visible - set(theirs))[:5]}")
    for name in visible:
        check(ours[name].read_bytes() == theirs[name].read_bytes(), f"{name} has other bytes")
    if whole:
        check(visible == set(theirs), f"missing: {sorted(set(theirs) - visible)[:5]}")
        strays = [name for name in ours if is_leftover(name)]
        strays += [str(p) for p in (out / STATE).rglob("*") if p.suffix in (".part", ".old")]
        check(not strays, f"left behind: {strays[:5]}")
        mine, other = ({p.relative_to(f / STATE / "pictures"): p.read_bytes()
                        for p in (f / STATE / "pictures").rglob("*.png")} for f in (out, reference))
        check(mine.keys() == other.keys(), f"pictures: {sorted(map(str, mine.keys() ^ other.keys()))[:5]}")
        check(mine == other, "pictures differ")
    return len(visible)


def records(out):
    """All complete lines of the journal."""
    path = out / STATE / "journal-1-of-1.jsonl"
    text = path.read_bytes() if path.exists() else b""
    return [json.loads(line) for line in text.split(b"\n")[:-1]]


def history(out):
    """Tries, ends and done ends by job; a job is a name and a key."""
    tries, ends, done = collections.Counter(), collections.Counter(), collections.Counter()
    for record in records(out):
        if started := record.get("started"):
            job = started["name"], started["key"]
            check(not done[job], f"{job[0]} was begun again after it was done")
            tries[job] += 1
        if ended := record.get("ended"):
            job = ended["name"], ended["key"]
            ends[job] += 1
            done[job] += ended["status"] == "done"
    return tries, ends, done


def rows(out):
    """Name, status and output of each job of the report, in order."""
    report = json.loads((out / "report.json").read_text())
    jobs = report.get("jobs") or report.get("rows")
    check(jobs, "report.json lists no jobs")
    of = lambda row: (row.get("outcome") or {})
    return [(row["name"], row["status"], of(row).get("bytes"), of(row).get("crc32")) for row in jobs]


# ---------------------------------------------------------------------------------------------- scenes


def undisturbed(batch, out, broken):
    begun = time.monotonic()
    code, said = batch.finish(out)
    seconds = time.monotonic() - begun
    check(code == (7 if broken else 0), f"the undisturbed run ended with {code}: {said}")
    failed = [row for row in rows(out) if row[1] != "done"]
    check(len(failed) == broken, f"{len(failed)} failed, {broken} are broken: {failed[:5]}")
    return seconds


def verify(out, reference, kills):
    compare(out, reference, whole=True)
    check(rows(out) == rows(reference), "the report tells of other results")
    tries, ends, done = history(out)
    names = {row[0] for row in rows(reference) if row[1] == "done"}
    check({name for (name, _), times in done.items() if times} == names, "the journal lacks jobs")
    twice = [job[0] for job, times in done.items() if times > 1]
    check(not twice, f"done twice: {twice[:5]}")
    # Each try beyond the first is one that was in hand at a kill.
    most = max(tries.values())
    check(most <= 1 + kills, f"a job was begun {most} times with {kills} kills")
    return sum(tries.values()) - len(tries)


def killed(batch, work, reference, seconds, kills, dice):
    """Kills at random moments until there were enough of them, in as many batches as that takes."""
    supervisors = workers = rounds = wasted = 0
    while supervisors + workers < kills:
        rounds += 1
        out = work / f"killed{rounds}"
        here = 0
        while True:
            process = batch.start(out)
            # Legs short enough that several fit into a batch, with some at once after the start.
            time.sleep(dice.choice((dice.uniform(0, 0.1), dice.uniform(0, 1.5 * seconds / 6))))
            if process.poll() is not None or supervisors + workers >= kills:
                break
            children = members(process.pid)
            here += 1
            if children and dice.random() < 0.3:
                workers += 1
                os.kill(dice.choice(children), signal.SIGKILL)
                # The batch goes on without it, and is killed in its turn in a while.
                time.sleep(dice.uniform(0, seconds / 6))
                if process.poll() is not None or supervisors + workers >= kills:
                    break
            supervisors += 1
            process.kill()
            process.wait()
            # Half of the time the next run begins while orphans are still about.
            if dice.random() < 0.5:
                wait_for_orphans(process.pid)
                done = compare(out, reference, whole=False)
                print(f"  kill {supervisors + workers}: {done} outputs in place, all whole", flush=True)
        said = process.communicate()[1].decode(errors="replace")
        check(process.returncode in (0, 7), f"the last run ended with {process.returncode}: {said}")
        wasted += verify(out, reference, here + 1)
        shutil.rmtree(out)
    print(f"killed {supervisors} supervisors and {workers} workers in {rounds} batches: all outputs equal,")
    print(f"  none missing, none done twice; {wasted} tries were in hand at a kill and begun again")


def harmed(batch, work, reference):
    """Outputs that went missing, were cut or changed are made again, and no others."""
    out = work / "harmed"
    batch.finish(out)
    before = history(out)[0]
    names = sorted(name for name in outputs(out))
    gone, cut, changed = names[0], names[1], names[2]
    (out / gone).unlink()
    os.truncate(out / cut, 10)
    journal = out / STATE / "journal-1-of-1.jsonl"
    lines = [line for line in journal.read_bytes().splitlines(True) if not line.startswith(b'{"checkpoint"')]
    # Loss of power: no checkpoint, so that contents count, and half a line at the end.
    journal.write_bytes(b"".join(lines) + lines[-2][: len(lines[-2]) // 2])
    with open(out / changed, "r+b") as file:
        file.seek(100)
        byte = file.read(1)[0]
        file.seek(100)
        file.write(bytes([byte ^ 1]))
    code, said = batch.finish(out)
    check(code in (0, 7), f"ended with {code}: {said}")
    compare(out, reference, whole=True)
    tries = collections.Counter()
    for record in records(out):
        if started := record.get("started"):
            tries[started["name"], started["key"]] += 1
    again = sorted(job[0] for job in tries if tries[job] > before[job])
    check(again == sorted((gone, cut, changed)), f"made again: {again}")
    code, said = batch.finish(out)
    check(sum(1 for r in records(out) if "started" in r) == sum(tries.values()), "the next run did work again")
    shutil.rmtree(out)
    print("one output deleted, one cut, one changed by a bit after the last checkpoint: these three made again")


def full(batch, work, reference):
    """A disk that is full on the way."""
    size = sum(path.stat().st_size for path in outputs(reference).values())
    out = work / "full"
    out.mkdir()
    small = ["mount", "-t", "tmpfs", "-o", f"size={max(size * 6 // 10 >> 12, 16) << 12}", "none", str(out)]
    if subprocess.run(small, capture_output=True).returncode != 0:
        print("full disk: skipped, as we may not mount a tmpfs here (be root)")
        return
    try:
        code, said = batch.finish(out)
        check(code in (6, 9), f"on a full disk it ended with {code}: {said}")
        check("resume" in said, f"the remedy is missing: {said}")
        done = compare(out, reference, whole=False)
        again, said = batch.finish(out)
        check(again in (6, 9), f"on a disk that is still full it ended with {again}: {said}")
        compare(out, reference, whole=False)
        subprocess.run(["mount", "-o", f"remount,size={4 * size + (1 << 24)}", str(out)], check=True)
        last, said = batch.finish(out)
        check(last in (0, 7), f"with room again it ended with {last}: {said}")
        verify(out, reference, 2)
        print(f"full disk after {done} outputs: exit code {code}, nothing half written; with room again all equal")
    finally:
        subprocess.run(["umount", "-l", str(out)], check=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--models", type=int, default=60)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(1 << 30))
    parser.add_argument("--keep", type=Path, help="work in this folder and leave it")
    # What follows -- is for batch.
    cut = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    args, flags = parser.parse_args(sys.argv[1:cut]), sys.argv[cut + 1 :]
    dice = random.Random(args.seed)
    print(f"seed {args.seed}", flush=True)
    work = Path(tempfile.mkdtemp(prefix="batch_kill-")) if args.keep is None else args.keep
    work.mkdir(exist_ok=True)
    models, reference = work / "models", work / "reference"
    try:
        broken = make_models(models, args.models, dice)
        # The reference is made without FLAGS: a device that fails must not change a byte.
        plain = Batch(args.program.resolve(), models, [])
        batch = Batch(args.program.resolve(), models, flags)
        seconds = undisturbed(plain, reference, broken)
        print(f"{args.models + 1} models, {broken} of them broken: {seconds:.1f} s undisturbed", flush=True)
        if flags:
            seconds = undisturbed(batch, work / "flags", broken)
            verify(work / "flags", reference, 1)
            warned = sum("the CPU took over" in str(record) for record in records(work / "flags"))
            print(f"with {' '.join(flags)}: {seconds:.1f} s, all equal; {warned} jobs lost their device")
        killed(batch, work, reference, seconds, args.kills, dice)
        harmed(batch, work, reference)
        full(batch, work, reference)
    except Wrong as wrong:
        print(f"NOT HELD: {wrong} (seed {args.seed}; see {work})")
        return 1
    if args.keep is None:
        shutil.rmtree(work)
    return 0


if __name__ == "__main__":
    sys.exit(main())
