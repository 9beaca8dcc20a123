#!/usr/bin/env python3
"""Holds the material of supports against PrusaSlicer's, at equal settings (peers/matched.ini with supports on).

usage: supports.py [--microtome PATH] [--models DIR] [--prusa DIR] [--json] [MODEL ...]

Prints, per model and style, the filament of columns and of dense layers [mm] of both programs, and ours / theirs. PrusaSlicer 2.5 has no
branches: `organic` stands beside its grid. A T and a comb are measured with dont_support_bridges = 0, because PrusaSlicer leaves arms
that are held at one end without support otherwise.
--prusa DIR keeps PrusaSlicer's G-code there and takes it from there the next time.
Needs the Debian package prusa-slicer. Models come from peers/make.py; `demo.stl` is made by whoever has it and left out otherwise.
"""
import argparse, json, os, re, shutil, subprocess, sys, tempfile

HERE = os.path.dirname(os.path.abspath(__file__)); PEERS = os.path.join(HERE, 'peers')
MODELS = ['tee.stl', 'cone_down.stl', 'arch.stl', 'stair.stl', 'comb.stl', 'demo.stl', 'benchy.stl']
ROLES = ('Support material', 'Support material interface')
SETTINGS = {'support_material': '1', 'support_material_threshold': '50', 'support_material_spacing': '2.5'}

def filament(path):
    """Filament of columns and of dense layers [mm]."""
    sums = dict.fromkeys(ROLES, 0.0); role = ''; e = 0.0; relative = False
    for line in open(path, errors='replace'):
        if line.startswith(';TYPE:'): role = line[6:].strip()
        elif line.startswith('M83'): relative = True
        elif line.startswith('M82'): relative = False
        elif line.startswith('G92'):
            m = re.search(r'E(-?[\d.]+)', line); e = float(m.group(1)) if m else e
        elif line.startswith('G1'):
            code = line.split(';')[0]; m = re.search(r'E(-?[\d.]+)', code)
            if not m: continue
            v = float(m.group(1)); d = v if relative else v - e; e = v
            if role in sums and ('X' in code or 'Y' in code): sums[role] += d
    return [sums[r] for r in ROLES]

def flags(style, bridges, prusa):
    s = dict(SETTINGS, support_material_style=style, dont_support_bridges=bridges)
    if not prusa: return [x for k, v in s.items() for x in ('--set', f'{k}={v}')]
    out = ['--support-material', '--support-material-threshold', '50', '--support-material-spacing', '2.5', '--support-material-style', style]
    return out + [f'--dont-support-bridges={bridges}']

def run(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode: sys.exit(f'{" ".join(command)}\n{done.stdout}')

def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('--microtome', default='target/release/microtome'); ap.add_argument('--prusa'); ap.add_argument('--json', action='store_true')
    ap.add_argument('--models', default=os.path.join(tempfile.gettempdir(), 'microtome-models')); ap.add_argument('model', nargs='*', default=MODELS)
    a = ap.parse_args(); ini = os.path.join(PEERS, 'matched.ini')
    made = [m for m in a.model if m != 'demo.stl' and not os.path.exists(m)]
    subprocess.run([sys.executable, os.path.join(PEERS, 'make.py'), a.models, *made], check=True, stdout=subprocess.DEVNULL)
    if not a.prusa and not shutil.which('prusa-slicer'): sys.exit('prusa-slicer is not installed')
    rows = []
    with tempfile.TemporaryDirectory() as tmp:
        kept = a.prusa or tmp; os.makedirs(kept, exist_ok=True)
        for model in a.model:
            path = model if os.path.exists(model) else os.path.join(a.models, model)
            if not os.path.exists(path): print(f'{model} left out: no such file', file=sys.stderr); continue
            stem = os.path.splitext(os.path.basename(model))[0]; bridges = '0' if stem in ('tee', 'comb') else '1'
            theirs = {}
            for style in ('grid', 'snug'):
                out = os.path.join(kept, f'{stem}_{style}{"0" if bridges == "0" else ""}.gcode')
                if not os.path.exists(out):
                    run(['prusa-slicer', '--loglevel', '1', '--load', ini, *flags(style, bridges, True), '-g', '-o', out, path])
                theirs[style] = filament(out)
            for style in ('grid', 'snug', 'organic'):
                out = os.path.join(tmp, 'own.gcode')
                run([a.microtome, 'slice', '--quiet', '--load', ini, *flags(style, bridges, False), '-o', out, path])
                own, peer = filament(out), theirs.get(style, theirs['grid'])
                rows.append(dict(model=stem, style=style, microtome_mm=own, prusa_mm=peer, ratio=sum(own) / max(sum(peer), 1e-9)))
    if a.json: print(json.dumps(rows)); return
    print(f'{"":12s}{"style":10s}{"columns":>10s}{"dense":>10s}{"theirs":>10s}{"dense":>10s}{"ours / theirs":>15s}')
    for r in rows:
        print(f'{r["model"]:12s}{r["style"]:10s}' + ''.join(f'{v:10.1f}' for v in r['microtome_mm'] + r['prusa_mm']) + f'{r["ratio"]:15.3f}')

main()
