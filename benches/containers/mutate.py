#!/usr/bin/env python3
"""Damages container files in thousands of ways and has `microtome inspect` read them.

    python3 benches/containers/mutate.py a.goo a.sl1 --runs 2000

Every run must end by itself, with exit code 0 or 3, within the limits of time and memory, with nothing or
one JSON object on stdout, and with code 3 with exactly one line on stderr that names the file. A summary line
per file goes to stdout as CSV. Files that break a rule are kept, and the exit code is 1. The same seed
damages the same bytes.
"""

import argparse
import csv
import json
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Values that fields are overwritten with: zero, one, the largest, the most negative, not a number, infinity.
WORDS = [0, 1, 0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0x7FC00000, 0x7F800000, 0x00010000, 0xFFFF]


def place(rng, length, size=1):
    """A place for `size` bytes; half of them near the start or the end, where the tables are."""
    last = max(length - size, 0)
    kind = rng.random()
    if kind < 0.35:
        return rng.randint(0, min(last, 4096))
    if kind < 0.5:
        return rng.randint(max(0, last - 4096), last)
    return rng.randint(0, last)


def truncate(rng, data):
    return data[: place(rng, len(data))]


def flip(rng, data):
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 8, 64])):
        data[place(rng, len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def byte(rng, data):
    data = bytearray(data)
    data[place(rng, len(data))] = rng.choice([0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)])
    return bytes(data)


def word(rng, data):
    at = place(rng, len(data), 4)
    if rng.random() < 0.7:
        at -= at % 4
    packed = struct.pack(rng.choice("<>") + "I", rng.choice(WORDS))
    return data[:at] + packed + data[at + 4 :]


def wipe(rng, data):
    size = rng.choice([4, 16, 64, 512, 4096])
    at = place(rng, len(data), size)
    filler = rng.choice([b"\0", b"\xff"]) * min(size, len(data) - at)
    return data[:at] + filler + data[at + size :]


def cut(rng, data):
    size = rng.choice([1, 2, 4, 32, 1024])
    at = place(rng, len(data), size)
    return data[:at] + data[at + size :]


def insert(rng, data):
    at = place(rng, len(data))
    return data[:at] + rng.randbytes(rng.choice([1, 2, 4, 32, 1024])) + data[at:]


def copy(rng, data):
    size = rng.choice([4, 16, 64, 1024])
    source, target = place(rng, len(data), size), place(rng, len(data), size)
    return data[:target] + data[source : source + size] + data[target + size :]


def lengthen(rng, data):
    return data + rng.randbytes(rng.choice([1, 4, 4096]))


MUTATIONS = [truncate, flip, flip, byte, word, word, wipe, cut, insert, copy, lengthen]


def inspect(program, path, limits):
    """Exit code (negative: killed), stdout, stderr, CPU seconds, peak memory in MB."""

    def limit():
        megabytes = limits.memory << 20
        resource.setrlimit(resource.RLIMIT_AS, (megabytes, megabytes))
        seconds = int(limits.seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = subprocess.Popen(
            [program, "inspect", "--json", path], stdout=out, stderr=err, stdin=subprocess.DEVNULL, preexec_fn=limit
        )
        deadline = time.monotonic() + 10 * limits.seconds
        while True:
            done, status, usage = os.wait4(child.pid, os.WNOHANG)
            if done:
                break
            if time.monotonic() > deadline:
                child.send_signal(signal.SIGKILL)
                _, status, usage = os.wait4(child.pid, 0)
                break
            time.sleep(0.001)
        child.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        cpu = usage.ru_utime + usage.ru_stime
        return child.returncode, out.read(), err.read().decode("utf-8", "replace"), cpu, usage.ru_maxrss / 1024


def judge(result, path, limits):
    """What is wrong with a run; None if nothing is."""
    code, out, err, cpu, _ = result
    if code not in (0, 3):
        return f"exit code {code}: {err.strip()[-200:]}"
    if cpu > limits.seconds:
        return f"{cpu:.1f} s of CPU"
    lines = err.splitlines()
    if code == 0 and lines:
        return f"exit code 0 with {lines[0]!r} on stderr"
    if code == 3 and (len(lines) != 1 or not lines[0].startswith("error: ") or path not in lines[0]):
        return f"not one line that names the file: {err[-300:]!r}"
    if out or code == 0:
        try:
            json.loads(out)
        except ValueError as e:
            return f"stdout is not JSON: {e}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--program", default="target/release/microtome")
    parser.add_argument("--runs", type=int, default=2000, help="damaged copies of each file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=10, help="CPU time of one run")
    parser.add_argument("--memory", type=int, default=2048, help="address space of one run in MB")
    parser.add_argument("--keep", type=Path, default=Path("mutants"), help="folder for files that break a rule")
    args = parser.parse_args()
    program = str(Path(args.program).resolve())
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(["file", "bytes", "runs", "seed", "refused", "read", "broken", "max_cpu_s", "max_mb"])
    broken_in_all = 0
    with tempfile.TemporaryDirectory() as folder:
        for file in args.files:
            whole = file.read_bytes()
            result = inspect(program, str(file), args)
            if result[0] != 0:
                sys.exit(f"{file} itself is not read: {result[2].strip()}")
            rng = random.Random(f"{args.seed} {file.name}")
            path = os.path.join(folder, "damaged" + file.suffix)
            refused = read = broken = 0
            slowest, largest = 0.0, 0.0
            for run in range(args.runs):
                mutation = rng.choice(MUTATIONS)
                damaged = mutation(rng, whole)
                Path(path).write_bytes(damaged)
                result = inspect(program, path, args)
                slowest, largest = max(slowest, result[3]), max(largest, result[4])
                refused += result[0] == 3
                read += result[0] == 0
                wrong = judge(result, path, args)
                if wrong:
                    broken += 1
                    args.keep.mkdir(exist_ok=True)
                    kept = args.keep / f"{file.stem}-{args.seed}-{run}{file.suffix}"
                    shutil.copyfile(path, kept)
                    print(f"{kept}: {mutation.__name__}: {wrong}", file=sys.stderr)
            figures = [f"{slowest:.2f}", f"{largest:.0f}"]
            table.writerow([file.name, len(whole), args.runs, args.seed, refused, read, broken, *figures])
            sys.stdout.flush()
            broken_in_all += broken
    sys.exit(1 if broken_in_all else 0)


if __name__ == "__main__":
    main()
