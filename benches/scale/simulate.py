#!/usr/bin/env python3
"""Simulates a batch of a million models on a hundred nodes from what single models were measured to cost. Needs numpy.

usage: simulate.py REPORT.csv --models MODELS.csv [--stages REPORT.json] [--jobs 1000000] [--nodes 100] [--cores 16] [...] [--csv FILE]

REPORT.csv is that of a measured batch: cpu_seconds, peak_bytes and bytes of every job that was done, and the tries that failed at no
cost; REPORT.json adds where a job's time goes; MODELS.csv (as models.py writes it, or any table with name and bytes) gives the sizes of the models.

The model. Jobs are drawn from the measured ones with replacement, each with its own CPU time, memory, input and output bytes together.
They fall into shards of equal chance, as the hash does it, or in equal pieces, as a manifest that was cut does it. A shard is a task that takes a
whole node. It reads and hashes what it must know, on --hash-threads threads: with --shard every model of the batch, with pieces its own. Its jobs run on the node's
cores beside that, the largest file first, one core a job, each as long as its CPU time, times --slowdown, plus --overhead; a job starts only while the memory of those in
flight allows. The task takes as long as the slowest of three: hashing, jobs, and its bytes at the node's share of the file system or of its own
network (a model that is hashed and then sliced on the same node is read once). Nodes die at random, exponentially, at --mtbf hours each; what the dead node had in
flight (half a job a core in the mean) is done again, what was finished is not; its shard starts again on the next node that is free after --requeue
seconds, with its hashing done anew; the node itself comes back after --repair.
"""
import argparse, csv, heapq, json, math
import numpy as np

def read(path):
    with open(path, newline='') as f: return list(csv.DictReader(f))

def measured(report, models):
    """Rows of (cpu s, memory, input bytes, output bytes)."""
    size = {r['name']: float(r['bytes']) for r in models}
    rows = []
    for r in report:
        into = size.get(r['model'].replace('\\', '/').rsplit('/', 1)[-1])
        if into is None: raise SystemExit(f'{r["model"]} is not in the table of models')
        if r['status'] == 'done': rows.append((float(r['cpu_seconds']), float(r['peak_bytes'] or 0), into, float(r['bytes'])))
        else: rows.append((0.0, 0.0, into, 0.0))
    return np.array(rows)

def stages(path):
    """Shares of the jobs' wall time by stage, as text."""
    with open(path) as f: jobs = json.load(f)['jobs']
    total = {}
    for j in jobs:
        for name, s in (j['outcome'] or {}).get('stages', []): total[name] = total.get(name, 0.0) + s
    whole = sum(total.values()) or 1.0
    return ', '.join(f'{name} {100 * s / whole:.0f} %' for name, s in sorted(total.items(), key=lambda x: -x[1]))

def makespan(jobs, cores, memory):
    """Largest file first, one core a job, memory bounded: time to the last end. jobs: rows of seconds, memory, input bytes."""
    order = np.argsort(-jobs[:, 2], kind='stable'); seconds, need = jobs[order, 0].tolist(), jobs[order, 1].tolist()
    running, used, now, end = [], 0.0, 0.0, 0.0
    for s, m in zip(seconds, need):
        while running and (len(running) >= cores or used + m > memory):
            now, gone = heapq.heappop(running); used -= gone
        heapq.heappush(running, (now + s, m)); used += m; end = max(end, now + s)
    return end

def campaign(rng, pool, a, by_hash, shards):
    """One run: a dictionary of results."""
    drawn = pool[rng.integers(len(pool), size=a.jobs)]
    seconds = drawn[:, 0] * a.slowdown + a.overhead
    if by_hash: cuts = np.cumsum(rng.multinomial(a.jobs, np.full(shards, 1 / shards)))
    else: cuts = np.linspace(0, a.jobs, shards + 1).round().astype(int)[1:]
    parts = np.split(np.arange(a.jobs), cuts[:-1])
    busy = min(a.nodes, shards)
    rate = min(a.network, a.file_system / busy) * 1e6
    all_in = drawn[:, 2].sum()
    work, hashing, own = np.zeros(shards), np.zeros(shards), np.zeros(shards)
    for i, p in enumerate(parts):
        work[i] = seconds[p].sum()
        compute = makespan(np.stack([seconds[p], drawn[p, 1], drawn[p, 2]], 1), a.cores, a.memory * 1e9)
        read, count = (all_in, a.jobs) if by_hash and shards > 1 else (drawn[p, 2].sum(), len(p))
        hashing[i] = max(read / rate, read / (a.hash_rate * 1e6) / a.hash_threads, count * a.open_seconds / a.hash_threads)
        own[i] = max(compute, (read + drawn[p, 3].sum()) / rate)
    # Nodes take shards in their order; the dead one's comes first again.
    free = [(0.0, n) for n in range(a.nodes)]; heapq.heapify(free)
    queue = [(0.0, i, own[i]) for i in range(shards)]; heapq.heapify(queue)
    end, deaths, lost = 0.0, 0, 0.0
    mean_job = seconds.mean()
    while queue:
        ready, i, left = heapq.heappop(queue); at, node = heapq.heappop(free)
        start = max(ready, at); life = rng.exponential(a.mtbf * 3600) if a.mtbf else math.inf; need = a.start + max(hashing[i], left)
        if life >= need:
            heapq.heappush(free, (start + need, node)); end = max(end, start + need); continue
        deaths += 1
        # Work goes on evenly while the models are hashed.
        done = left * max(0.0, life - a.start) / max(need - a.start, 1e-9); again = min(done, 0.5 * mean_job)
        lost += (min(life, a.start) + again) * a.cores + max(0.0, life - a.start - done) * a.cores
        heapq.heappush(queue, (start + life + a.requeue, i, left - done + again)); heapq.heappush(free, (start + life + a.repair, node))
    whole = a.nodes * a.cores * end
    return dict(makespan=end, utilisation=work.sum() / whole, lost=lost / whole, deaths=deaths, imbalance=work.max() / work.mean() - 1,
                cpu_hours=work.sum() / 3600, read_tb=all_in * (shards if by_hash and shards > 1 else 1) / 1e12, written_tb=drawn[:, 3].sum() / 1e12,
                bound=work.sum() / a.nodes / a.cores)

def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('report'); ap.add_argument('--models', required=True); ap.add_argument('--stages'); ap.add_argument('--jobs', type=int, default=1_000_000); ap.add_argument('--nodes', type=int, default=100)
    ap.add_argument('--cores', type=int, default=16); ap.add_argument('--memory', type=float, default=32, help='budget of a node [GB]')
    ap.add_argument('--overhead', type=float, default=0.0, help='CPU a job beside its own [s]'); ap.add_argument('--slowdown', type=float, default=1.0, help='of a core when all are busy')
    ap.add_argument('--hash-rate', type=float, default=500, help='of a thread [MB/s]'); ap.add_argument('--hash-threads', type=int, default=1, help='that hash at a time on a node')
    ap.add_argument('--open-seconds', type=float, default=0.0, help='to open a file to be hashed [s]')
    ap.add_argument('--network', type=float, default=1250, help='of a node [MB/s]'); ap.add_argument('--file-system', type=float, default=10_000, help='of all nodes together [MB/s]')
    ap.add_argument('--start', type=float, default=5, help='of a task [s]'); ap.add_argument('--mtbf', type=float, default=1000, help='of a node [h]; 0 = none dies')
    ap.add_argument('--requeue', type=float, default=40, help='from death to the next start [s]'); ap.add_argument('--repair', type=float, default=600, help='until a node is back [s]')
    ap.add_argument('--shards', default='100,400'); ap.add_argument('--seeds', type=int, default=5); ap.add_argument('--csv')
    a = ap.parse_args()
    models = read(a.models); pool = measured(read(a.report), models)
    cpu = pool[:, 0]; cv = cpu.std() / cpu.mean()
    print(f'measured: {len(pool)} jobs, CPU mean {cpu.mean() * 1e3:.1f} ms, median {np.median(cpu) * 1e3:.1f}, 99 % {np.quantile(cpu, 0.99) * 1e3:.0f}, most {cpu.max() * 1e3:.0f}, '
          f'coefficient of variation {cv:.2f}; the dearest 1 % take {100 * np.sort(cpu)[::-1][:max(1, len(cpu) // 100)].sum() / cpu.sum():.0f} %')
    print(f'          model mean {pool[:, 2].mean() / 1e6:.3f} MB, output mean {pool[:, 3].mean() / 1e6:.3f} MB, memory of a worker at most {pool[:, 1].max() / 1e6:.0f} MB')
    if a.stages: print('          stages: ' + stages(a.stages))
    print(f'all {a.jobs} jobs: {cpu.mean() * a.jobs / 3600:.1f} CPU hours, {pool[:, 2].mean() * a.jobs / 1e12:.2f} TB of models, {pool[:, 3].mean() * a.jobs / 1e12:.2f} TB of outputs')
    out = []
    for shards in map(int, a.shards.split(',')):
        n = a.jobs / shards; sigma = math.sqrt((1 + cv * cv) / n); top = math.sqrt(2 * math.log(shards)) if shards > 1 else 0
        print(f'\n{shards} shards of about {n:.0f} jobs: standard deviation of a shard\'s work {100 * sigma:.1f} % (sqrt((1 + cv^2) / n)), the largest of all about +{100 * sigma * top:.0f} % at most')
        print(f'{"":24s}{"makespan s":>22s}{"slicing %":>11s}{"lost %":>9s}{"deaths":>8s}{"largest shard":>15s}{"read TB":>9s}{"bound s":>9s}')
        for by_hash in (True, False):
            runs = [campaign(np.random.default_rng([seed, shards, by_hash]), pool, a, by_hash, shards) for seed in range(a.seeds)]
            mid = lambda k: float(np.median([r[k] for r in runs])); low, high = (f([r['makespan'] for r in runs]) for f in (min, max))
            name = 'by hash (--shard)' if by_hash else 'pieces of a manifest'
            print(f'{name:24s}{mid("makespan"):8.0f} ({low:.0f} to {high:.0f})'.ljust(46) + f'{100 * mid("utilisation"):11.1f}{100 * mid("lost"):9.2f}'
                  f'{np.mean([r["deaths"] for r in runs]):8.1f}{"+" + format(100 * mid("imbalance"), ".1f") + " %":>15s}{mid("read_tb"):9.1f}{mid("bound"):9.0f}')
            out += [dict(shards=shards, by_hash=int(by_hash), seed=s, **{k: round(v, 5) for k, v in r.items()}) for s, r in enumerate(runs)]
    if a.csv:
        with open(a.csv, 'w', newline='') as f: w = csv.DictWriter(f, list(out[0]), lineterminator='\n'); w.writeheader(); w.writerows(out)

main()
