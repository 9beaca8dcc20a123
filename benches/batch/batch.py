#!/usr/bin/env python3
"""Models per minute of `microtome batch` against loops of one process a model, on one folder, in one run, on the same cores.

usage: batch.py MODELS [--microtome PATH] [--only batch,slice,prusa,cura] [--runs 2] [--memory 2G] [--csv FILE] [--per-model FILE]

  batch      microtome batch MODELS -o OUT
  slice      for each model: microtome slice
  prusa      for each model: prusa-slicer (prusa-rear: without its ray casting for seams)
  cura       for each model: CuraEngine
  estimate   microtome batch --estimate-only (not in --only's default); its material is held against that of `batch`
Peers run as ../peers/compare.py runs them, with the settings of ../peers/matched.ini. Each process of a loop may use all cores, as in a
shell's loop; --peer-jobs N runs N of them at a time, as xargs -P N does. MODELS comes from models.py; its models.csv says what is to be
sliced and what is to be refused.

Every file is read once before, so that none pays for a cold disk. Order: batch and slice, the peers, batch and slice again, up to --runs in
all; peers run once. Times are wall, and user + system of all processes. A model that takes longer than --limit is a timeout. Ratios are given with
timeouts at the limit, and without these models on either side (the batch's time without them by their share of its CPU time); the latter is judged.
Busy is CPU time over wall time times cores; `machine` is what /proc/stat says, others' processes included. Memory is the sum of resident
sets over the tree of processes, pages they share counted for each, sampled ten times a second; shorter peaks are missed; of loops
it is the largest resident set of a process, which is never below Python's own 26 MB.
With --sample K every program gets every K-th model only: the rows say so, and no verdict is given.

Exit code 0 when the marks hold: 25 x prusa, 15 x cura, 1.5 x slice, busy above 90 %, memory within --memory, outcome of every model as
models.csv says, bytes of batch and slice equal; estimates: material equal, 3 x faster.
"""
import argparse, csv, hashlib, json, os, re, shutil, statistics, subprocess, sys, tempfile, threading, time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, '..', 'peers'))
import compare

MARKS = {'prusa': 25.0, 'cura': 15.0, 'slice': 1.5}
PAGE, TICK = os.sysconf('SC_PAGE_SIZE'), os.sysconf('SC_CLK_TCK')

class Watch(threading.Thread):
    """Samples the resident sets of a tree of processes."""

    def __init__(self, pid):
        super().__init__(daemon=True); self.pid, self.peak, self.ended = pid, 0, threading.Event()

    def tree(self):
        found, queue = [], [self.pid]
        while queue:
            pid = queue.pop(); found.append(pid)
            try:
                for task in os.listdir(f'/proc/{pid}/task'): queue += map(int, open(f'/proc/{pid}/task/{task}/children').read().split())
            except OSError: pass
        return found

    def run(self):
        while not self.ended.wait(0.1):
            total = 0
            for pid in self.tree():
                try: total += int(open(f'/proc/{pid}/statm').read().split()[1]) * PAGE
                except (OSError, IndexError): pass
            self.peak = max(self.peak, total)

def machine_busy():
    """Busy and all ticks of the machine so far."""
    t = list(map(int, open('/proc/stat').readline().split()[1:9])); return sum(t) - t[3] - t[4], sum(t)

def run(command, env, limit, watch=False, log=None):
    """One process to its end: wall, CPU, peak, exit code."""
    start = time.perf_counter()
    p = subprocess.Popen(command, env=env, stdin=subprocess.DEVNULL, stdout=log or subprocess.DEVNULL, stderr=log or subprocess.DEVNULL)
    late = threading.Event()
    def kill(): late.set(); p.kill()
    timer = threading.Timer(limit, kill) if limit else None
    if timer: timer.start()
    w = Watch(p.pid) if watch else None
    if w: w.start()
    _, status, use = os.wait4(p.pid, 0); wall = time.perf_counter() - start; p.returncode = os.waitstatus_to_exitcode(status)
    if timer: timer.cancel()
    if w: w.ended.set(); w.join()
    return dict(wall=wall, cpu=use.ru_utime + use.ru_stime, mb=(w.peak if w else use.ru_maxrss * 1024) / 1e6, rc='timeout' if late.is_set() else p.returncode)

EXTRUDES = re.compile(rb'^G[123] (?=[^;\n]*[XY])[^;\n]*E-?[0-9.]', re.M)

def judge(path, rc):
    """ok, blank (exit code 0, but no file or nothing printed in it), failed or timeout."""
    if rc == 'timeout': return 'timeout'
    if rc != 0: return 'failed'
    if not os.path.exists(path): return 'blank'
    with open(path, 'rb') as f:
        while block := f.read(1 << 20):
            if EXTRUDES.search(block): return 'ok'
    return 'blank'

def loop(tool, names, folder, out, a):
    """One process a model."""
    env0 = dict(os.environ, SOURCE_DATE_EPOCH='0'); per, lock, todo = {}, threading.Lock(), list(reversed(names))
    ours = tool == 'slice'
    def work():
        while True:
            with lock:
                if not todo: return
                name = todo.pop()
            path = os.path.join(out, os.path.splitext(name)[0] + '.gcode')
            if ours: command, env = [a.microtome, 'slice', '--load', a.ini, '--quiet', '-o', path, os.path.join(folder, name)], env0
            else: command, env = compare.command(tool, os.path.join(folder, name), path, a.microtome, a.ini, None)
            r = run(command, env or env0, a.limit); r['path'] = path
            with lock: per[name] = r
    start = time.perf_counter()
    threads = [threading.Thread(target=work) for _ in range(1 if ours else a.peer_jobs)]
    for t in threads: t.start()
    for t in threads: t.join()
    wall = time.perf_counter() - start
    for r in per.values():
        r['result'] = judge(r['path'], r['rc'])
        if not ours and os.path.exists(r['path']): os.unlink(r['path'])
    return wall, sum(r['cpu'] for r in per.values()), max(r['mb'] for r in per.values()), per

def batch(tool, names, folder, out, a, log):
    """All models in one command."""
    command = [a.microtome, 'batch', folder, '-o', out, '--load', a.ini, '--memory', a.memory, '--quiet', *(['--estimate-only'] if tool == 'estimate' else []), *a.flag]
    r = run(command, dict(os.environ, SOURCE_DATE_EPOCH='0'), None, watch=True, log=log)
    if r['rc'] not in (0, 7): sys.exit(f'microtome batch ended with {r["rc"]}: {tail(log.name)}')
    rows = {os.path.basename(x['model']): x for x in read_csv(os.path.join(out, 'report.csv'))}
    per = {}
    for n in names:
        x = rows.get(n); path = os.path.join(out, os.path.splitext(n)[0] + '.gcode')
        result = 'missing' if x is None else 'failed' if x['status'] != 'done' else 'ok' if tool == 'estimate' else judge(path, 0)
        per[n] = dict(result=result, wall=number(x, 'seconds'), cpu=number(x, 'cpu_seconds'), mb=number(x, 'peak_bytes') / 1e6, path=path, row=x)
    return r['wall'], r['cpu'], r['mb'], per

def number(row, key):
    try: return float((row or {}).get(key) or 'nan')
    except ValueError: return float('nan')

def read_csv(path):
    with open(path, newline='') as f: return list(csv.DictReader(f))

def tail(path):
    with open(path, 'rb') as f: return f.read()[-300:].decode(errors='replace').strip()

def digest(path):
    with open(path, 'rb') as f: return hashlib.file_digest(f, 'sha256').digest()

def sample_folder(models, names, k, tmp):
    folder = os.path.join(tmp, 'models'); os.makedirs(folder)
    for n in names[::k]:
        try: os.link(os.path.join(models, n), os.path.join(folder, n))
        except OSError: shutil.copy(os.path.join(models, n), folder)
    return folder, names[::k]

def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('models'); ap.add_argument('--microtome', default='target/release/microtome'); ap.add_argument('--only', default='batch,slice,prusa,cura')
    ap.add_argument('--runs', type=int, default=2); ap.add_argument('--memory', default='2G'); ap.add_argument('--limit', type=float, default=60)
    ap.add_argument('--sample', type=int, default=1); ap.add_argument('--peer-jobs', type=int, default=1); ap.add_argument('--ini', default=os.path.join(HERE, '..', 'peers', 'matched.ini'))
    ap.add_argument('--csv'); ap.add_argument('--per-model'); ap.add_argument('--folder', help='where outputs go [default: the temporary folder]')
    ap.add_argument('--flag', action='append', default=[], help='a further flag of microtome batch, as --flag=--no-pictures')
    a = ap.parse_args()
    a.microtome, a.ini = os.path.abspath(a.microtome), os.path.abspath(a.ini)
    expected = {r['name']: r['expected'] for r in read_csv(os.path.join(a.models, 'models.csv'))}
    tools = a.only.split(',')
    for t in list(tools):
        program = {'prusa': 'prusa-slicer', 'prusa-rear': 'prusa-slicer', 'cura': 'CuraEngine'}.get(t, a.microtome)
        if not shutil.which(program): print(f'{t} left out: no {program}', file=sys.stderr); tools.remove(t)
    if 'cura' in tools: compare.cura_resources()
    own = [t for t in tools if t in ('batch', 'slice', 'estimate')]; peers = [t for t in tools if t not in own]
    first = (a.runs + 1) // 2
    order = own * first + peers + own * (a.runs - first)
    cores = len(os.sched_getaffinity(0)); rows, per_model, notes, bad = [], [], [], []
    with tempfile.TemporaryDirectory(dir=a.folder) as tmp:
        # The folder that batch gets holds the models and nothing else: models.csv would be taken for a manifest.
        names = sorted(expected)
        folder, names = sample_folder(a.models, names, a.sample, tmp)
        label = 'all' if a.sample == 1 else f'every {a.sample}th'
        for n in names:
            with open(os.path.join(folder, n), 'rb') as f:
                while f.read(1 << 22): pass
        size = sum(os.path.getsize(os.path.join(folder, n)) for n in names)
        print(f'{len(names)} models ({label}), {size / 1e6:.0f} MB, {cores} cores, load before {os.getloadavg()[0]:.2f}', flush=True)
        print(f'{"":10s}{"models/min":>11s}{"wall s":>9s}{"cpu s":>9s}{"busy %":>8s}{"machine %":>10s}{"peak MB":>9s}{"ok":>6s}{"failed":>8s}{"blank":>7s}{"timeout":>9s}{"unlike models.csv":>19s}', flush=True)
        hashes, material, times, late, own_cpu = {}, {}, {}, {}, {}
        for k, tool in enumerate(order):
            out = os.path.join(tmp, f'{k}-{tool}'); os.makedirs(out); b0, t0 = machine_busy()
            with open(os.path.join(tmp, f'{k}-{tool}.log'), 'wb') as log:
                wall, cpu, mb, per = batch(tool, names, folder, out, a, log) if tool in ('batch', 'estimate') else loop(tool, names, folder, out, a)
            b1, t1 = machine_busy()
            count = lambda r: sum(p['result'] == r for p in per.values())
            unlike = [n for n, p in per.items() if (p['result'] == 'ok') != (expected[n] != 'refused')]
            row = dict(tool=tool, run=order[:k].count(tool) + 1, models=len(names), sample=a.sample, jobs=a.peer_jobs if tool in peers else 1, cores=cores,
                       models_per_min=round(60 * len(names) / wall, 1), wall_s=round(wall, 3), cpu_s=round(cpu, 3), busy=round(cpu / wall / cores, 4),
                       machine_busy=round((b1 - b0) / max(1, t1 - t0), 4), peak_mb=round(mb, 1), ok=count('ok'), failed=count('failed') + count('missing'), blank=count('blank'),
                       timeouts=count('timeout'), wall_without_timeouts_s=round(wall - sum(p['wall'] for p in per.values() if p['result'] == 'timeout') / (a.peer_jobs if tool in peers else 1), 3),
                       unlike_expected=len(unlike))
            rows.append(row); times.setdefault(tool, []).append(row)
            print(f'{tool:10s}{row["models_per_min"]:11.1f}{wall:9.2f}{cpu:9.2f}{100 * row["busy"]:8.1f}{100 * row["machine_busy"]:10.1f}{mb:9.0f}{row["ok"]:6d}{row["failed"]:8d}{row["blank"]:7d}{row["timeouts"]:9d}{len(unlike):19d}', flush=True)
            per_model += [(tool, row['run'], n, p['result'], round(p['wall'], 4), round(p['cpu'], 4), round(p['mb'], 1)) for n, p in sorted(per.items())]
            if tool in own and unlike: bad.append(f'{tool}: {len(unlike)} models came out otherwise than models.csv says, such as {unlike[:3]}')
            if tool in ('batch', 'slice'):
                h = {n: digest(p['path']) for n, p in per.items() if p['result'] == 'ok'}
                other = hashes.setdefault('first', h); differ = [n for n in h if other.get(n) != h[n]] + [n for n in other if n not in h]
                if differ: bad.append(f'{tool}: {len(differ)} outputs differ from those of {order[0]}, such as {sorted(differ)[:3]}')
            late.setdefault(tool, {n for n, p in per.items() if p['result'] == 'timeout'})
            if tool == 'batch': own_cpu = {n: p['cpu'] for n, p in per.items() if p['cpu'] == p['cpu']}
            if tool in ('batch', 'estimate'): material.setdefault(tool, {n: grams(p['row']) for n, p in per.items() if p['result'] == 'ok'})
            shutil.rmtree(out)
    def marks():
        best = times.get('batch')
        if not best: return
        wall = statistics.median(r['wall_s'] for r in best)
        for t, rs in times.items():
            if t == 'batch': continue
            w = statistics.median(r['wall_s'] for r in rs); ratio = w / wall; whole = sum(own_cpu.values())
            share = 1 - sum(own_cpu.get(n, 0) for n in late[t]) / whole if whole else 1
            less = statistics.median(r['wall_without_timeouts_s'] for r in rs) / (wall * share)
            if t == 'estimate':
                yield 1 / ratio >= 3, f'estimate is {1 / ratio:.2f} x as fast as batch (mark 3)'
                differ = [n for n, m in material['estimate'].items() if m != material['batch'].get(n)]
                yield not differ, f'material of {len(material["estimate"]) - len(differ)} of {len(material["estimate"])} estimates is that of the full run' + (f', not of {differ[:3]}' if differ else '')
                continue
            text = f'batch is {ratio:.2f} x as fast as the loop of {t}' + (f', {less:.2f} x without its {rs[0]["timeouts"]} timeouts on either side' if rs[0]['timeouts'] else '')
            mark = MARKS.get(t); yield mark is None or less >= mark, text + (f' (mark {mark:g})' if mark else '')
        busy = statistics.median(r['busy'] for r in best); yield busy > 0.9, f'{100 * busy:.1f} % of {cores} cores busy with the batch (mark 90)'
        peak = max(r['peak_mb'] for r in best); yield peak * 1e6 <= size_of(a.memory), f'peak memory {peak:.0f} MB of {a.memory}'
    judged = list(marks())
    for good, text in judged: print(('  ok      ' if good else '  MISSED  ') + text)
    for text in bad: print('  FAILED  ' + text)
    if {'batch', 'slice'} <= times.keys() and not any('differ' in b for b in bad): print('  ok      outputs of batch and slice are byte-equal')
    for path, head, body in ((a.csv, list(rows[0]), [list(r.values()) for r in rows]), (a.per_model, ['tool', 'run', 'model', 'result', 'wall_s', 'cpu_s', 'peak_mb'], per_model)):
        if path:
            with open(path, 'w', newline='') as f: w = csv.writer(f, lineterminator='\n'); w.writerow(head); w.writerows(body)
    if a.sample > 1: print(f'VERDICT: none, a sample ({label}) of the models'); sys.exit(1 if bad else 0)
    good = not bad and all(g for g, _ in judged)
    print('VERDICT:', 'good' if good else 'FAILED' if bad else 'marks missed'); sys.exit(0 if good else 1)

def grams(row):
    """All of a row that speaks of material."""
    return tuple(sorted((k, v) for k, v in row.items() if re.search(r'filament|material|volume|cm3|_g$|^g$|_mm$|^mm$|cost|layers', k)))

def size_of(text):
    m = re.fullmatch(r'([\d.]+)([kmgt]?)(?:i?b)?', text.strip().lower()) or sys.exit(f'{text}: no size')
    return float(m[1]) * 1024 ** ' kmgt'.index(m[2] or ' ')

main()
