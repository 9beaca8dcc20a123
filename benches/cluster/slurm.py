#!/usr/bin/env python3
"""Tries a batch on a Slurm cluster of two nodes on this machine, and kills one of them in the middle.

usage: slurm.py WORK --microtome PATH --models DIR [--load FILE.ini] [--tasks 8] [--kill-at 0.3] [--back-after 60]
       slurm.py WORK --dummy             (the same with a stand-in that sleeps and writes files; no microtome needed)
       slurm.py WORK --microtome PATH --models DIR --stop   (no node dies: a running task is put back into the queue, as by preemption)

Starts munged, slurmctld and two slurmd in the folder WORK (made anew; nothing outside it is touched), without systemd and cgroups. Then:
  1. an undisturbed run of the whole batch by one process, for comparison: WORK/alone
  2. the same batch as an array job (array.sbatch beside this script) over both nodes: WORK/out
  3. when the share --kill-at of its outputs is there, kill -9 of everything that runs on node n1: slurmd, slurmstepd, tasks;
     whatever output has its final name at that moment is compared with the undisturbed run's
  4. --back-after seconds later n1 comes back
  5. when all tasks are done: every output there, byte-equal, nothing half written, the merged report complete

Prints a table of times and the verdict; exit code 0 only when all held. Needs Debian packages slurm-wlm and munge, and ports 17000 to 17002.
"""
import argparse, csv, getpass, hashlib, json, os, re, shutil, signal, socket, subprocess, sys, time

HERE = os.path.dirname(os.path.abspath(__file__))
NODES = ('n1', 'n2')
STATE = '.microtome'
DUMMY = '''#!/bin/bash
# Stands in for microtome: batch INPUT -o OUT --shard I/N sleeps and writes 25 files a shard; what is there is skipped.
out= shard=1/1
while [ $# -gt 0 ]; do case $1 in -o) out=$2; shift;; --shard) shard=$2; shift;; esac; shift; done
mkdir -p "$out"
trap 'exit 9' TERM
for s in $(if [ "$shard" = 1/1 ]; then seq 8; else echo "${shard%/*}"; fi); do
    for k in $(seq 25); do
        f=$out/$s-$k.gcode
        [ -e "$f" ] && continue
        [ "$shard" = 1/1 ] || sleep 0.2
        { echo "$s $k"; seq 1000; } > "$f.part.$$" && mv "$f.part.$$" "$f"
    done
done
'''

def say(text): print(f'{time.strftime("%H:%M:%S")} {text}', flush=True)

class Cluster:
    """The daemons, all ours, in one folder."""

    def __init__(self, work, cpus, timeout, expire):
        self.work, self.daemons = work, {}
        self.timeout, self.expire = timeout, expire
        values = dict(HOST=socket.gethostname().split('.')[0], PORT='17000', USER=getpass.getuser(), WORK=work, CPUS=str(cpus),
                      TIMEOUT=str(timeout), EXPIRE=str(expire))
        text = open(os.path.join(HERE, 'slurm.conf.in')).read()
        for key, value in values.items(): text = text.replace(f'@{key}@', value)
        for d in ('munge', 'state', *('spool-' + n for n in NODES)): os.makedirs(os.path.join(work, d))
        open(os.path.join(work, 'slurm.conf'), 'w').write(text)
        # Commands inside jobs ask the controller too, so that the variable must reach them.
        self.env = dict(os.environ, SLURM_CONF=os.path.join(work, 'slurm.conf'))

    def path(self, *names): return os.path.join(self.work, *names)

    def start(self, name, *command):
        log = open(self.path(f'{name}.out'), 'ab')
        self.daemons[name] = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=self.env, start_new_session=True)

    def start_node(self, node): self.start(node, find('slurmd'), '-N', node, '-D', '-f', self.path('slurm.conf'))

    def up(self):
        with open(self.path('munge', 'key'), 'wb') as f: f.write(os.urandom(1024))
        os.chmod(self.path('munge', 'key'), 0o600); os.chmod(self.path('munge'), 0o755)
        m = lambda n: self.path('munge', n)
        self.start('munged', find('munged'), '--foreground', '--socket', m('socket'), '--key-file', m('key'), '--pid-file', m('pid'),
                   '--log-file', m('log'), '--seed-file', m('seed'))
        wait_for('the socket of munged', 10, lambda: os.path.exists(m('socket')))
        self.start('slurmctld', find('slurmctld'), '-D', '-f', self.path('slurm.conf'))
        for n in NODES: self.start_node(n)
        wait_for('both nodes to be idle', 60, lambda: all(s.startswith('idle') for s in self.states().values()) and len(self.states()) == 2)

    def ask(self, *command, check=True):
        return subprocess.run(command, env=self.env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=check).stdout

    def states(self):
        return dict(line.split() for line in self.ask('sinfo', '-h', '-N', '-o', '%N %t', check=False).splitlines())

    def tasks(self):
        """Of every array task that Slurm still knows: index, state, starts after the first, node."""
        out = {}
        for line in self.ask('scontrol', 'show', 'job', '-o', check=False).splitlines():
            get = lambda key: (re.search(rf'(?:^| ){key}=(\S*)', line) or [None, ''])[1]
            for index in numbers(get('ArrayTaskId')): out[index] = dict(state=get('JobState'), restarts=int(get('Restarts') or 0), node=get('NodeList'))
        return out

    def processes(self, node):
        """All that runs on a node: its slurmd, the step daemons, the tasks and what these have started."""
        parent, found = {}, set()
        daemon = self.daemons[node].pid
        for pid in map(int, filter(str.isdigit, os.listdir('/proc'))):
            try:
                stat = open(f'/proc/{pid}/stat').read(); parent[pid] = int(stat[stat.rindex(')') + 2:].split()[1])
                environment = open(f'/proc/{pid}/environ', 'rb').read().split(b'\0')
                ours = f'SLURM_CONF={self.path("slurm.conf")}'.encode() in environment
                if pid == daemon or ours and f'SLURMD_NODENAME={node}'.encode() in environment: found.add(pid)
                elif os.path.realpath(f'/proc/{pid}/cwd').startswith(self.path('spool-' + node)): found.add(pid)
            except OSError: pass
        steps = {p for p in (parent.get(p) for p in found) if p and name_of(p) == 'slurmstepd'}
        found |= steps
        while True:
            more = {pid for pid, p in parent.items() if p in found} - found
            if not more: return found
            found |= more

    def kill_node(self, node):
        """The node dies: first everything stops, so that nothing sees another thing die, then all is killed."""
        while True:
            pids = self.processes(node)
            for s in (signal.SIGSTOP, signal.SIGKILL):
                for pid in pids:
                    try: os.kill(pid, s)
                    except ProcessLookupError: pass
            self.daemons[node].poll()
            if not self.processes(node) - {self.daemons[node].pid}: return

    def down(self):
        self.ask('scancel', '-u', getpass.getuser(), check=False)
        for n in NODES:
            if n in self.daemons: self.kill_node(n)
        for name in ('slurmctld', 'munged'):
            p = self.daemons.get(name)
            if p and p.poll() is None:
                p.terminate()
                try: p.wait(15)
                except subprocess.TimeoutExpired: p.kill()

def numbers(text):
    """`3`, `1-4`, `2,5-8%4`."""
    for part in filter(None, text.split('%')[0].split(',')):
        a, _, b = part.partition('-')
        yield from range(int(a), int(b or a) + 1)

def name_of(pid):
    try: return open(f'/proc/{pid}/comm').read().strip()
    except OSError: return ''

def find(program):
    path = shutil.which(program) or shutil.which(program, path='/usr/sbin:/sbin')
    return path or sys.exit(f'{program} is not installed: apt install slurm-wlm munge')

def wait_for(what, seconds, test, pause=0.2):
    end = time.time() + seconds
    while not test():
        if time.time() > end: raise TimeoutError(f'{what}: not within {seconds} s')
        time.sleep(pause)

def outputs(folder):
    """Name -> SHA-256 of every file of a batch's folder but its own records."""
    out = {}
    for root, folders, files in os.walk(folder):
        if root == folder: folders[:] = [f for f in folders if f != STATE]
        for f in files:
            name = os.path.relpath(os.path.join(root, f), folder)
            if not re.fullmatch(r'report(-\d+-of-\d+)?\.(json|csv|html)|quarantine(-\d+-of-\d+)?\.jsonl', name):
                with open(os.path.join(root, f), 'rb') as h: out[name] = hashlib.file_digest(h, 'sha256').hexdigest()
    return out

def log_times(log):
    """Of each shard: when it began (one entry a start, with the node) and when and how it ended."""
    begun, ended = {}, {}
    for line in open(log, errors='replace') if os.path.exists(log) else ():
        m = re.match(r'([\d.]+) shard (\d+)/\d+ (?:on (\w+), start (\d+)|ended with (\d+))', line)
        if m and m[3]: begun.setdefault(int(m[2]), []).append((float(m[1]), m[3]))
        elif m: ended.setdefault(int(m[2]), []).append((float(m[1]), int(m[5])))
    return begun, ended

def rows(folder):
    """Name -> status of the merged report."""
    with open(os.path.join(folder, 'report.csv'), newline='') as f:
        return {r['name']: r['status'] for r in csv.DictReader(f)}

def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('work'); ap.add_argument('--microtome'); ap.add_argument('--models', nargs='+', default=[]); ap.add_argument('--load')
    ap.add_argument('--tasks', type=int, default=8); ap.add_argument('--cpus', type=int, default=max(1, (os.cpu_count() or 1) // 2), help='cores of a node')
    ap.add_argument('--kill-at', type=float, default=0.3); ap.add_argument('--back-after', type=float, default=60)
    ap.add_argument('--node-timeout', type=int, default=5, help='SlurmdTimeout [s]'); ap.add_argument('--requeue-wait', type=int, default=10, help='cred_expire [s]')
    ap.add_argument('--limit', type=float, default=3600, help='give up after this time [s]')
    ap.add_argument('--stop', action='store_true'); ap.add_argument('--dummy', action='store_true'); ap.add_argument('--keep', action='store_true', help='leave WORK as it is')
    a = ap.parse_args()
    work = os.path.abspath(a.work)
    if os.path.exists(work): sys.exit(f'{work} exists; name a folder that does not')
    if len(work) > 80: sys.exit(f'{work}: too long for the path of a socket')
    os.makedirs(work)
    if a.dummy:
        a.microtome, a.models = os.path.join(work, 'dummy'), ['models']
        open(a.microtome, 'w').write(DUMMY); os.chmod(a.microtome, 0o755)
    if not a.microtome or not a.models: sys.exit('--microtome and --models, or --dummy')
    a.microtome = os.path.abspath(a.microtome); a.models = [m if a.dummy else os.path.abspath(m) for m in a.models]
    flags = ['--load', os.path.abspath(a.load)] if a.load else []
    failed = []
    def check(good, text):
        print(('  ok      ' if good else '  FAILED  ') + text, flush=True)
        if not good: failed.append(text)

    cluster = Cluster(work, a.cpus, a.node_timeout, a.requeue_wait)
    alone, out, log = (os.path.join(work, n) for n in ('alone', 'out', 'tasks.log'))
    try:
        say('one process, undisturbed')
        t = time.time()
        code = subprocess.run([a.microtome, 'batch', *a.models, '-o', alone, '--quiet', '--threads', str(2 * a.cpus), *flags]).returncode
        alone_seconds = time.time() - t
        if code not in (0, 7): sys.exit(f'the undisturbed run ended with {code}')
        expected = outputs(alone)
        say(f'{len(expected)} outputs in {alone_seconds:.1f} s')

        say('starting munged, slurmctld and two slurmd')
        cluster.up()
        hosts = cluster.ask('srun', '-N2', '-n2', '-l', 'sh', '-c', 'echo $SLURMD_NODENAME')
        check(sorted(hosts.split()) == ['0:', '1:', 'n1', 'n2'], f'srun reaches both nodes ({" ".join(hosts.split())})')
        run_array(a, cluster, expected, flags, check, (alone, out, log), alone_seconds)
        judge(a, expected, check, (alone, out, log), code)
    except (TimeoutError, subprocess.CalledProcessError, OSError) as e:
        check(False, str(e) + (f': {e.stderr}' if getattr(e, 'stderr', None) else ''))
    finally:
        cluster.down()
        left = [p for n in NODES if n in cluster.daemons for p in cluster.processes(n) if p != cluster.daemons[n].pid]
        check(not left, 'no process is left')
    print('VERDICT:', 'good' if not failed else f'FAILED ({len(failed)}), logs in {work}')
    if not failed and not a.keep: shutil.rmtree(work)
    sys.exit(1 if failed else 0)

def run_array(a, cluster, expected, flags, check, folders, alone_seconds):
    """The array job, and what befalls it."""
    alone, out, log = folders
    cluster.env['MICROTOME'] = a.microtome
    begin = time.time()
    cluster.ask('sbatch', f'--array=1-{a.tasks}', f'--cpus-per-task={a.cpus}', f'--output={log}', os.path.join(HERE, 'array.sbatch'),
                out, *a.models, '--', *flags)
    say(f'{a.tasks} tasks submitted')
    deadline = begin + a.limit
    there = lambda: sum(os.path.exists(os.path.join(out, n)) for n in expected)
    def running():
        begun, ended = log_times(log)
        return [i for i, v in begun.items() if v[-1][1] == 'n1' and len(ended.get(i, [])) < len(v)]
    # Five: slurmd, slurmstepd, the job script, the batch, at least one worker.
    ready = lambda: there() >= a.kill_at * len(expected) and running() and len(cluster.processes('n1')) >= 5
    wait_for('outputs before the node is to die', a.limit, ready, 0.05)
    hit = running()
    if a.stop:
        at = time.time()
        for i in hit: cluster.ask('scontrol', 'requeue', f'{array_id(cluster)}_{i}')
        say(f'task {hit} on n1 put back into the queue (SIGTERM, then SIGKILL after KillWait), {there()} of {len(expected)} outputs there')
    else:
        victims = len(cluster.processes('n1')); cluster.kill_node('n1'); at = time.time()
        now = {n: h for n, h in outputs(out).items() if n in expected}
        say(f'n1 killed ({victims} processes, tasks {hit}), {len(now)} of {len(expected)} outputs there')
        check(all(h == expected[n] for n, h in now.items()), f'the {len(now)} outputs with final names at that moment are whole')
        noticed = back = None
    first_down = None
    while True:
        tasks, states = cluster.tasks(), cluster.states()
        if not a.stop:
            if noticed is None and not states.get('n1', '').startswith(('idle', 'alloc', 'mix')) and states.get('n1', '').startswith('down'):
                noticed = time.time() - at; say(f'the controller has noticed after {noticed:.1f} s')
            if back is None and time.time() - at >= a.back_after:
                cluster.start_node('n1'); back = time.time() - at; say('n1 comes back')
        if tasks and all(t['state'] in ('COMPLETED', 'FAILED') for t in tasks.values()) and (a.stop or back is not None): break
        if time.time() > deadline: raise TimeoutError(f'the array job has not ended within {a.limit:.0f} s: {tasks}')
        time.sleep(0.25)
    begun, ended = log_times(log)
    end = max(t for times in ended.values() for t, _ in times)
    say('all tasks have ended')
    again = {i: [t - at for t, _ in begun.get(i, []) if t > at] for i in hit}
    check(all(len(v) >= 1 for v in again.values()), f'tasks {hit} were started again')
    check(all(len(v) == (2 if i in hit else 1) for i, v in begun.items()), 'the others were started once')
    check(len(begun) == a.tasks and all(v[-1][1] in (0, 7) for v in ended.values()), 'every task has ended well')
    if a.stop: check(all(ended[i][0][1] == 9 for i in hit), 'the task put back ended with 9')
    print(f'  wall time alone, {2 * a.cpus} threads            {alone_seconds:8.1f} s')
    print(f'  wall time of the array job, two nodes  {end - begin:8.1f} s')
    if not a.stop: print(f'  death of n1 -> noticed                 {noticed if noticed is not None else float("nan"):8.1f} s   (SlurmdTimeout {a.node_timeout} s)')
    for i, v in again.items():
        what = 'requeue' if a.stop else 'death of n1'
        print(f'  {what} -> task {i} runs again        {min(v, default=float("nan")):8.1f} s   (cred_expire {a.requeue_wait} s; on {next((n for t, n in begun[i] if t > at), "?")})')
    if not a.stop:
        later = [t for v in begun.values() for t, n in v if n == 'n1' and t > at + back]
        print(f'  n1 back -> first task on it            {min(later) - at - back if later else float("nan"):8.1f} s')
    print('  starts: ' + ', '.join(f'{i} on {"+".join(n for _, n in begun[i])}' for i in sorted(begun)), flush=True)

def array_id(cluster):
    line = cluster.ask('squeue', '-h', '-o', '%F').split()
    return line[0]

def judge(a, expected, check, folders, code):
    """The outputs and the report."""
    alone, out, log = folders
    got = outputs(out)
    missing, differ, extra = expected.keys() - got.keys(), [n for n in expected if n in got and got[n] != expected[n]], got.keys() - expected.keys()
    check(not missing, f'{len(expected) - len(missing)} of {len(expected)} outputs are there' + (f', missing: {sorted(missing)[:5]}' if missing else ''))
    check(not differ, 'all are byte-equal to the undisturbed run' + (f', but {sorted(differ)[:5]}' if differ else ''))
    check(not extra, 'nothing half written and nothing else lies about' + (f', but {sorted(extra)[:5]}' if extra else ''))
    if a.dummy: return
    r = subprocess.run([a.microtome, 'report', out, '--json'], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    check(r.returncode == code, f'microtome report ends with {r.returncode}, the undisturbed run ended with {code} {r.stderr.strip()}')
    try:
        with open(os.path.join(out, 'report.json')) as f: jobs = len(json.load(f)['jobs'])
    except ValueError as e: jobs = str(e)
    check(jobs == len(rows(alone)), f'report.json has {jobs} jobs')
    ours, theirs = rows(out), rows(alone)
    check(ours == theirs, f'the merged report has the {len(theirs)} rows of the undisturbed run, with the same status')

main()
