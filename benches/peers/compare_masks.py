#!/usr/bin/env python3
"""Holds `microtome mask` against other resin slicers, on the same models, in one run.

usage: compare_masks.py [--microtome PATH] [--mslicer PATH] [--models DIR] [--runs N] [--panel 12k|16k]
                        [--formats goo,sl1] [--peers mslicer,prusa] [--json] [MODEL ...]

Runs the commands in turn (A B C A B C ...) on a panel of 11520 x 5120 pixels of 19 x 24 um (16k: 15120 x 6230 of 14 x 19 um), 0.05 mm
layers, no anti-aliasing, and prints the median CPU seconds (user + system), wall seconds, peak memory and file size of each, and
peer / microtome. mslicer writes .goo and PrusaSlicer .sl1, so each is held against microtome's file of the same kind.

--mslicer: the `slicer` program of https://github.com/connorslade/mslicer, built with `cargo build --release -p slicer`.
PrusaSlicer takes minutes a model at this size; it is run once. Models come from make.py.
"""
import argparse, json, os, shutil, statistics, subprocess, sys, tempfile, time

HERE = os.path.dirname(os.path.abspath(__file__))
PANELS = {'12k': ('elegoo-saturn-3-ultra', 11520, 5120, 218.88, 122.88), '16k': ('elegoo-saturn-4-ultra-16k', 15120, 6230, 211.68, 118.37)}

PRUSA = """printer_technology = SLA
bed_shape = 0x0,{w}x0,{w}x{h},0x{h}
display_width = {w}
display_height = {h}
display_pixels_x = {px}
display_pixels_y = {py}
display_orientation = landscape
display_mirror_x = 1
display_mirror_y = 0
max_print_height = 300
layer_height = 0.05
initial_layer_height = 0.05
supports_enable = 0
pad_enable = 0
gamma_correction = 0
absolute_correction = 0
elefant_foot_compensation = 0
slice_closing_radius = 0
"""

def run(cmd, limit=1200):
    t0 = time.monotonic()
    with tempfile.TemporaryFile() as log:
        p = subprocess.Popen(cmd, stdout=log, stderr=log)
        while True:
            pid, status, use = os.wait4(p.pid, os.WNOHANG)
            if pid: break
            if time.monotonic() - t0 > limit:
                p.kill(); _, status, use = os.wait4(p.pid, 0); p.returncode = -9
                return dict(cpu=use.ru_utime + use.ru_stime, wall=time.monotonic() - t0, mb=use.ru_maxrss / 1024, rc='timeout')
            time.sleep(0.002)
        p.returncode = os.waitstatus_to_exitcode(status)
        if p.returncode:
            log.seek(0); sys.stderr.write(log.read().decode(errors='replace')[-400:])
    return dict(cpu=use.ru_utime + use.ru_stime, wall=time.monotonic() - t0, mb=use.ru_maxrss / 1024, rc=p.returncode)

def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('--microtome', default='target/release/microtome'); ap.add_argument('--mslicer')
    ap.add_argument('--models', default=os.path.join(tempfile.gettempdir(), 'microtome-models'))
    ap.add_argument('--runs', type=int, default=5); ap.add_argument('--panel', default='12k', choices=PANELS)
    ap.add_argument('--formats', default='goo,sl1'); ap.add_argument('--peers', default='mslicer,prusa'); ap.add_argument('--json', action='store_true')
    ap.add_argument('--folder', help='where outputs go; a tmpfs keeps the disk out of the figures')
    ap.add_argument('model', nargs='*', default=['benchy.stl', 'knot_1M.stl', 'plate9_benchy.stl', 'pins_1600.stl', 'sphere_1M.stl'])
    a = ap.parse_args()
    missing = [os.path.basename(m) for m in a.model if not os.path.exists(m)]
    if missing: subprocess.run([sys.executable, os.path.join(HERE, 'make.py'), a.models, *missing], check=True, stdout=subprocess.DEVNULL)
    printer, px, py, w, h = PANELS[a.panel]
    peers = a.peers.split(',')
    report = []
    for m in a.model:
        path = m if os.path.exists(m) else os.path.join(a.models, m)
        with tempfile.TemporaryDirectory(dir=a.folder) as tmp:
            ini = os.path.join(tmp, 'sla.ini'); open(ini, 'w').write(PRUSA.format(w=w, h=h, px=px, py=py))
            commands = {}
            for kind in a.formats.split(','):
                commands[f'microtome {kind}'] = [a.microtome, 'mask', path, '-q', '--printer', printer, '--layer-height', '0.05', '-o', os.path.join(tmp, f'm.{kind}')]
            if a.mslicer and 'mslicer' in peers:
                commands['mslicer goo'] = [a.mslicer, '--mesh', path, '--position', '0,0,0', '--platform-resolution', f'{px},{py}', '--platform-size', f'{w},{h},300',
                                           '--layer-height', '0.05', os.path.join(tmp, 's.goo')]
            if shutil.which('prusa-slicer') and 'prusa' in peers:
                commands['prusa sl1'] = ['prusa-slicer', '--loglevel', '1', '--load', ini, '--export-sla', '-o', os.path.join(tmp, 'p.sl1'), path]
            got = {t: [] for t in commands}
            size = {}
            for i in range(a.runs):
                for t, c in commands.items():
                    if t.startswith('prusa') and i: continue
                    if got[t] and got[t][-1]['rc'] != 0: continue
                    got[t].append(run(c))
                    out = c[-1] if t.startswith('mslicer') else c[c.index('-o') + 1]
                    size[t] = os.path.getsize(out) if os.path.exists(out) else 0
                    if os.path.exists(out): os.unlink(out)
            rows = {t: dict({k: statistics.median(r[k] for r in got[t]) for k in ('cpu', 'wall', 'mb')}, rc=got[t][-1]['rc'], bytes=size[t]) for t in commands}
        for t in rows:
            base = rows.get('microtome ' + t.split()[1])
            if not t.startswith('microtome') and base and rows[t]['rc'] != 'timeout':
                rows[t]['cpu_ratio'] = rows[t]['cpu'] / max(base['cpu'], 1e-9); rows[t]['wall_ratio'] = rows[t]['wall'] / max(base['wall'], 1e-9)
        report.append(dict(model=os.path.basename(m), panel=a.panel, cores=os.cpu_count(), rows=rows))
        if not a.json:
            print(f'\n{os.path.basename(m)} on {px} x {py} ({os.cpu_count()} cores, median of {a.runs})')
            print(f'{"":16s}{"cpu s":>9s}{"wall s":>9s}{"peak MB":>9s}{"file MB":>9s}{"cpu x":>8s}{"wall x":>8s}  rc')
            for t, r in rows.items():
                print(f'{t:16s}{r["cpu"]:9.3f}{r["wall"]:9.3f}{r["mb"]:9.0f}{r["bytes"] / 1e6:9.1f}{r.get("cpu_ratio", float("nan")):8.2f}{r.get("wall_ratio", float("nan")):8.2f}  {r["rc"]}', flush=True)
    if a.json: print(json.dumps(report))

main()
