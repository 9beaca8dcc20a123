#!/usr/bin/env python3
"""Holds `microtome slice` against the slicers people use, on the same models, in one run.

usage: compare.py [--microtome PATH] [--ini FILE] [--models DIR] [--runs N] [--peers prusa,prusa-rear,cura]
                  [--supports grid|snug|organic] [--json] [MODEL ...]

Runs the commands in turn (A B C A B C ...) with matched settings (matched.ini: 0.2 mm layers, 0.45 mm lines, 3 walls, 3 + 3 solid
layers, 20 % rectilinear, no support) and prints, per model, the median CPU seconds (user + system), wall seconds, peak memory, net
filament and layer count of each, and peer / microtome of CPU and wall. Machines are noisy: quote the ratios, and give the number of cores.

Needs Debian packages: prusa-slicer, cura-engine (a peer that is not installed is left out, and said). CuraEngine's printer definitions
come from the Debian package `cura`, which is downloaded and unpacked into the temporary folder on first use.
--ini gives other settings to microtome and PrusaSlicer (CuraEngine keeps its own).
--supports turns supports on in all programs: slopes below 50 degrees, lines 2.5 mm apart, gaps of 0.2 mm above and below and 0.225 mm beside,
three dense layers. CuraEngine makes its normal supports, for organic its tree; PrusaSlicer 2.5 has no branches and makes its grid.
`prusa` places seams by ray casting (its default, about half of its time); `prusa-rear` leaves that out. Quote both.
Models come from make.py beside this script; they are written to DIR (default: microtome-models in the temporary folder) when missing.
microtome is called as: microtome slice --load matched.ini -o OUT MODEL
"""
import argparse, json, os, re, shutil, statistics, subprocess, sys, tempfile, time

HERE = os.path.dirname(os.path.abspath(__file__))

def cura_resources():
    home = os.path.join(tempfile.gettempdir(), 'microtome-cura'); base = os.path.join(home, 'usr/share/cura/resources')
    if not os.path.isdir(base):
        os.makedirs(home, exist_ok=True)
        subprocess.run('apt-get download -q cura && dpkg -x cura_*.deb .', shell=True, cwd=home, check=True, stdout=subprocess.DEVNULL)
    return base

def cura_supports(style):
    """As PrusaSlicer's: threshold 50 degrees from horizontal is 40 from upright; a line of 0.45 mm every 2.907 mm."""
    structure = 'tree' if style == 'organic' else 'normal'
    density = 100 * 0.45 / 2.907
    return (f'support_enable=true support_structure={structure} support_type=everywhere support_angle=40 support_tree_angle=40 support_pattern=zigzag '
            f'support_infill_rate={density:.1f} support_line_distance=2.907 support_initial_layer_line_distance=2.907 '
            'support_z_distance=0.2 support_top_distance=0.2 support_bottom_distance=0.2 support_xy_distance=0.225 support_xy_distance_overhang=0.225 '
            'support_wall_count=1 support_interface_enable=true support_roof_enable=true support_bottom_enable=true support_interface_height=0.6 '
            'support_roof_height=0.6 support_bottom_height=0.6 support_roof_density=100 support_bottom_density=100 support_roof_line_distance=0.45 '
            'support_bottom_line_distance=0.45 support_interface_pattern=lines support_roof_pattern=lines support_bottom_pattern=lines '
            'support_offset=0 support_join_distance=2 speed_support=60 speed_support_infill=60 speed_support_interface=60').split()

def prusa_supports(style):
    if not style: return []
    return ['--support-material', '--support-material-threshold', '50', '--support-material-style', 'snug' if style == 'snug' else 'grid']

def cura_command(model, out, style):
    base = cura_resources()
    s = ('machine_name=t machine_width=400 machine_depth=400 machine_height=300 machine_center_is_zero=false layer_height=0.2 '
         'layer_height_0=0.2 line_width=0.45 wall_line_width=0.45 wall_line_width_0=0.45 wall_line_width_x=0.45 infill_line_width=0.45 '
         'skin_line_width=0.45 support_line_width=0.45 initial_layer_line_width_factor=100 wall_line_count=3 wall_thickness=1.35 '
         'top_layers=3 bottom_layers=3 initial_bottom_layers=3 top_bottom_thickness=0.6 roofing_layer_count=0 infill_sparse_density=20 '
         'infill_line_distance=2.25 infill_pattern=lines infill_overlap_mm=0.045 skin_overlap_mm=0.0225 top_bottom_pattern=lines '
         'top_bottom_pattern_0=lines adhesion_type=none support_enable=false support_structure=normal support_angle=50 '
         'machine_nozzle_size=0.4 material_diameter=1.75 center_object=true mesh_position_x=0 mesh_position_y=0 mesh_position_z=0 '
         'speed_wall_0=60 speed_wall_x=60 speed_infill=60 speed_topbottom=60 speed_travel=150 speed_layer_0=60 '
         'material_print_temperature=210 material_print_temperature_layer_0=210 material_bed_temperature=60 '
         'material_bed_temperature_layer_0=60 retraction_combing=off cool_min_layer_time=0 skin_preshrink=0 top_skin_preshrink=0 '
         'bottom_skin_preshrink=0 expand_skins_expand_distance=0 top_skin_expand_distance=0 bottom_skin_expand_distance=0 '
         'meshfix_maximum_resolution=0.005 meshfix_maximum_deviation=0.0025 meshfix_maximum_travel_resolution=0.1').split()
    # What comes last counts.
    s += cura_supports(style) if style else []
    a = [x for kv in s for x in ('-s', kv)]
    env = dict(os.environ, CURA_ENGINE_SEARCH_PATH=f'{base}/definitions:{base}/extruders')
    return ['CuraEngine', 'slice', '-m2', '-j', f'{base}/definitions/fdmprinter.def.json', *a, '-e0', *a, '-o', out, '-l', model, *a], env

def command(tool, model, out, microtome, ini, style):
    own = ['--support-material', '--support-material-threshold', '50', '--support-material-style', style] if style else []
    prusa = ['prusa-slicer', '--loglevel', '1', '--load', ini, *prusa_supports(style)]
    if tool == 'microtome': return [microtome, 'slice', '--load', ini, *own, '-o', out, model], None
    if tool == 'prusa': return [*prusa, '-g', '-o', out, model], None
    if tool == 'prusa-rear': return [*prusa, '--seam-position', 'rear', '-g', '-o', out, model], None
    if tool == 'cura': return cura_command(model, out, style)
    sys.exit(f'no such peer: {tool}')

def run(cmd, env, limit):
    t0 = time.monotonic()
    with tempfile.TemporaryFile() as log:
        p = subprocess.Popen(cmd, stdout=log, stderr=log, env=env)
        while True:
            pid, status, use = os.wait4(p.pid, os.WNOHANG)
            if pid: break
            if time.monotonic() - t0 > limit:
                p.kill(); _, status, use = os.wait4(p.pid, 0); p.returncode = -9
                return dict(cpu=use.ru_utime + use.ru_stime, wall=time.monotonic() - t0, mb=use.ru_maxrss / 1024, rc='timeout')
            time.sleep(0.002)
        p.returncode = os.waitstatus_to_exitcode(status)
    return dict(cpu=use.ru_utime + use.ru_stime, wall=time.monotonic() - t0, mb=use.ru_maxrss / 1024, rc=p.returncode)

def filament(path):
    """Net filament [mm] and number of distinct extruding Z values."""
    e = net = 0.0; rel = False; z = None; zs = set()
    for line in open(path, errors='replace'):
        c = line.split(';', 1)[0]
        if c.startswith(('G0', 'G1', 'G2', 'G3')):
            m = re.search(r'Z(-?[\d.]+)', c)
            if m: z = m.group(1)
            m = re.search(r'E(-?[\d.]+)', c)
            if m:
                v = float(m.group(1)); d = v if rel else v - e; net += d
                if not rel: e = v
                if d > 0 and ('X' in c or 'Y' in c): zs.add(z)
        elif c.startswith('M83'): rel = True
        elif c.startswith('M82'): rel = False
        elif c.startswith('G92'):
            m = re.search(r'E(-?[\d.]+)', c)
            if m: e = float(m.group(1))
    return net, len(zs)

def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('--microtome', default='target/release/microtome'); ap.add_argument('--models', default=os.path.join(tempfile.gettempdir(), 'microtome-models'))
    ap.add_argument('--ini', default=os.path.join(HERE, 'matched.ini')); ap.add_argument('--runs', type=int, default=5); ap.add_argument('--peers', default='prusa,prusa-rear,cura')
    ap.add_argument('--limit', type=float, default=120); ap.add_argument('--json', action='store_true')
    ap.add_argument('--supports', choices=('grid', 'snug', 'organic'))
    ap.add_argument('model', nargs='*', default=['benchy.stl', 'knot_1M.stl', 'comb.stl'])
    a = ap.parse_args()
    subprocess.run([sys.executable, os.path.join(HERE, 'make.py'), a.models, *[os.path.basename(m) for m in a.model if not os.path.exists(m)]],
                   check=True, stdout=subprocess.DEVNULL)
    tools = (['microtome'] if os.path.exists(a.microtome) else []) + [p for p in a.peers.split(',') if p]
    for t in list(tools):
        program = {'prusa': 'prusa-slicer', 'prusa-rear': 'prusa-slicer', 'cura': 'CuraEngine'}.get(t)
        if program and not shutil.which(program):
            print(f'{t} left out: {program} is not installed', file=sys.stderr); tools.remove(t)
    report = []
    for m in a.model:
        path = m if os.path.exists(m) else os.path.join(a.models, m)
        got = {t: [] for t in tools}; out = {}
        with tempfile.TemporaryDirectory() as tmp:
            for _ in range(a.runs):
                for t in tools:
                    if got[t] and got[t][-1]['rc'] == 'timeout': continue
                    out[t] = os.path.join(tmp, t + '.gcode')
                    got[t].append(run(*command(t, path, out[t], a.microtome, a.ini, a.supports), a.limit))
            rows = {}
            for t in tools:
                med = {k: statistics.median(r[k] for r in got[t]) for k in ('cpu', 'wall', 'mb')}
                mm, layers = filament(out[t]) if os.path.exists(out[t]) else (0.0, 0)
                rows[t] = dict(med, rc=got[t][-1]['rc'], filament_mm=round(mm, 1), layers=layers)
        base = rows.get('microtome')
        for t in tools:
            if base and t != 'microtome' and rows[t]['rc'] != 'timeout':
                rows[t]['cpu_ratio'] = rows[t]['cpu'] / max(base['cpu'], 1e-9); rows[t]['wall_ratio'] = rows[t]['wall'] / max(base['wall'], 1e-9)
        report.append(dict(model=os.path.basename(m), cores=os.cpu_count(), rows=rows))
        if not a.json:
            print(f'\n{os.path.basename(m)} ({os.cpu_count()} cores, median of {a.runs})')
            print(f'{"":12s}{"cpu s":>9s}{"wall s":>9s}{"peak MB":>9s}{"filament":>10s}{"layers":>8s}{"cpu x":>8s}{"wall x":>8s}  rc')
            for t in tools:
                r = rows[t]
                print(f'{t:12s}{r["cpu"]:9.3f}{r["wall"]:9.3f}{r["mb"]:9.0f}{r["filament_mm"]:10.0f}{r["layers"]:8d}'
                      f'{r.get("cpu_ratio", float("nan")):8.2f}{r.get("wall_ratio", float("nan")):8.2f}  {r["rc"]}')
    if a.json: print(json.dumps(report))

if __name__ == '__main__': main()
