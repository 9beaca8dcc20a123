#!/usr/bin/env python3
"""Writes the measuring models as binary STL into a folder. Standard library only.

usage: make.py OUT [NAME ...]      (all of them where no NAME is given; existing files are kept)

benchy.stl and plate9_benchy.stl are made from 3DBenchy.3mf (CreativeTools, github.com/CreativeTools/3DBenchy), which is
not kept here: set BENCHY_3MF to its path, or put it beside this script. Without it these two are left out.
"""
import array, math, os, struct, sys, zipfile
import xml.etree.ElementTree as ET

HERE = os.path.dirname(os.path.abspath(__file__))

def write(path, triangles):
    """triangles: iterable of 9 floats (three corners), outward winding."""
    n = 0
    with open(path + '.part', 'wb') as f:
        f.write(b'measuring model'.ljust(80)); f.write(struct.pack('<I', 0))
        pack = struct.Struct('<12fH').pack
        buf = bytearray()
        for t in triangles:
            ux, uy, uz = t[3]-t[0], t[4]-t[1], t[5]-t[2]
            vx, vy, vz = t[6]-t[0], t[7]-t[1], t[8]-t[2]
            nx, ny, nz = uy*vz-uz*vy, uz*vx-ux*vz, ux*vy-uy*vx
            l = math.sqrt(nx*nx+ny*ny+nz*nz) or 1.0
            buf += pack(nx/l, ny/l, nz/l, *t, 0); n += 1
            if len(buf) > 1 << 22: f.write(buf); buf.clear()
        f.write(buf); f.seek(80); f.write(struct.pack('<I', n))
    os.replace(path + '.part', path)
    print(os.path.basename(path), n)

def benchy_path():
    return os.environ.get('BENCHY_3MF', os.path.join(HERE, '3DBenchy.3mf'))

def benchy():
    ns = '{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}'
    with zipfile.ZipFile(benchy_path()) as z:
        name = next(n for n in z.namelist() if n.endswith('.model'))
        root = ET.fromstring(z.read(name))
    out = []
    for mesh in root.iter(ns + 'mesh'):
        v = [(float(p.get('x')), float(p.get('y')), float(p.get('z'))) for p in mesh.iter(ns + 'vertex')]
        for t in mesh.iter(ns + 'triangle'):
            out.append(v[int(t.get('v1'))] + v[int(t.get('v2'))] + v[int(t.get('v3'))])
    lo = [min(min(t[i::3]) for t in out) for i in range(3)]
    return [tuple(c - lo[i % 3] for i, c in enumerate(t)) for t in out]

def plate9():
    b = benchy()
    for i in range(9):
        dx, dy = 66.0 * (i % 3), 36.0 * (i // 3)
        for t in b:
            yield (t[0]+dx, t[1]+dy, t[2], t[3]+dx, t[4]+dy, t[5], t[6]+dx, t[7]+dy, t[8])

def grid(fn, nu, nv):
    """Closed surface on a torus grid; fn(i, j) -> point."""
    rows = [[fn(i, j) for j in range(nv)] for i in range(nu)]
    zmin = min(p[2] for r in rows for p in r)
    rows = [[(x, y, z - zmin) for x, y, z in r] for r in rows]
    for i in range(nu):
        a, b = rows[i], rows[(i + 1) % nu]
        for j in range(nv):
            k = (j + 1) % nv
            yield a[j] + b[j] + b[k]
            yield a[j] + b[k] + a[k]

def knot(nu=2500, nv=200, p=2, q=3, R=30.0, r0=12.0, rt=6.0):
    def centre(t):
        r = R + r0 * math.cos(q * t)
        return (r * math.cos(p * t), r * math.sin(p * t), -1.6 * r0 * math.sin(q * t))
    frames = []
    for i in range(nu):
        t = 2 * math.pi * i / nu
        c, c2 = centre(t), centre(t + 1e-5)
        T = [c2[k] - c[k] for k in range(3)]; l = math.sqrt(sum(x * x for x in T)); T = [x / l for x in T]
        l = math.hypot(c[0], c[1]); up = [c[0] / l, c[1] / l, 0.0]
        d = sum(up[k] * T[k] for k in range(3)); N = [up[k] - d * T[k] for k in range(3)]
        l = math.sqrt(sum(x * x for x in N)); N = [x / l for x in N]
        B = [T[1]*N[2]-T[2]*N[1], T[2]*N[0]-T[0]*N[2], T[0]*N[1]-T[1]*N[0]]
        frames.append((c, N, B, t))
    def point(i, j):
        c, N, B, t = frames[i]; a = 2 * math.pi * j / nv
        r = rt * (1 + 0.03 * math.sin(12 * a) * math.sin(200 * t))
        return tuple(c[k] + r * (math.cos(a) * N[k] + math.sin(a) * B[k]) for k in range(3))
    return grid(lambda i, j: point(i, nv - j), nu, nv)

def sphere(nu=1000, nv=502, r=40.0):
    def point(i, j):
        th, ph = 2 * math.pi * i / nu, math.pi * j / (nv - 1)
        return (r*math.sin(ph)*math.cos(th), r*math.sin(ph)*math.sin(th), r - r*math.cos(ph))
    for i in range(nu):
        for j in range(nv - 1):
            a, b, c, d = point(i, j), point((i+1) % nu, j), point((i+1) % nu, j+1), point(i, j+1)
            if j: yield a + b + c
            if j < nv - 2: yield a + c + d

def cylinder(n=25000, r=20.0, h=200.0):
    ring = [(r*math.cos(2*math.pi*i/n), r*math.sin(2*math.pi*i/n)) for i in range(n)]
    for i in range(n):
        (ax, ay), (bx, by) = ring[i], ring[(i+1) % n]
        yield (ax, ay, 0, bx, by, 0, bx, by, h)
        yield (ax, ay, 0, bx, by, h, ax, ay, h)
        yield (0, 0, 0, bx, by, 0, ax, ay, 0)
        yield (0, 0, h, ax, ay, h, bx, by, h)

def box(x0, y0, z0, x1, y1, z1):
    p = [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
    for a, b, c, d in ((0,2,3,1), (4,5,7,6), (0,1,5,4), (2,6,7,3), (0,4,6,2), (1,3,7,5)):
        yield p[a] + p[b] + p[c]
        yield p[a] + p[c] + p[d]

def pins():
    for i in range(40):
        for j in range(40):
            yield from box(3.0*i, 3.0*j, 0, 3.0*i + 0.9, 3.0*j + 0.9, 60.0)

def comb():
    """Boxes that overlap by 0.5 mm (a union of shells): base, walls 0.4..1.2 mm, a bridge, a 0.3 mm slot, steps that overhang."""
    yield from box(0, 0, 0, 80, 40, 3)
    for k, w in enumerate((0.4, 0.45, 0.6, 0.8, 0.9, 1.0, 1.2)):
        yield from box(4 + 6*k, 4, 2.5, 4 + 6*k + w, 20, 15)
    yield from box(4, 26, 2.5, 10, 36, 15); yield from box(40, 26, 2.5, 46, 36, 15)
    yield from box(4, 26, 14.5, 46, 36, 17)
    yield from box(52, 4, 2.5, 57.85, 36, 12); yield from box(58.15, 4, 2.5, 64, 36, 12)
    for k in range(5):
        yield from box(66, 4, 2.5 + 4*k, 70 + 2*k, 36, 7 + 4*k)

def extruded(outline, triangles, y0, y1):
    """The profile `outline` (x, z), counter-clockwise, cut into `triangles` (indices), from y0 to y1."""
    for a, b, c in triangles:
        a, b, c = outline[a], outline[b], outline[c]
        yield (a[0], y0, a[1], b[0], y0, b[1], c[0], y0, c[1])
        yield (a[0], y1, a[1], c[0], y1, c[1], b[0], y1, b[1])
    for i, (ax, az) in enumerate(outline):
        bx, bz = outline[(i + 1) % len(outline)]
        yield (ax, y0, az, ax, y1, az, bx, y1, bz)
        yield (ax, y0, az, bx, y1, bz, bx, y0, bz)

def tee():
    """A T: a stem of 10 mm under a bar of 50 mm."""
    p = [(-5, 0), (5, 0), (5, 20), (25, 20), (25, 26), (-25, 26), (-25, 20), (-5, 20)]
    yield from extruded(p, [(0, 1, 2), (0, 2, 7), (2, 3, 4), (2, 4, 5), (2, 5, 7), (5, 6, 7)], 0, 20)

def arch(n=48):
    """A round arch: two feet of 6 mm, an opening of 40 mm, 26 mm high."""
    inner = [(-20*math.cos(math.pi*i/n), 20*math.sin(math.pi*i/n)) for i in range(n + 1)]
    # Above every point of the opening one on the outside, at the same x, the feet's corners apart.
    p = [(-26, 0)] + inner + [(26, 0), (26, 26)] + [(x, 26) for x, _ in reversed(inner)] + [(-26, 26)]
    top = lambda i: n + 3 + 1 + (n - i)
    last = len(p) - 1
    t = [(0, 1, top(0)), (0, top(0), last), (n + 1, n + 2, n + 3), (n + 1, n + 3, top(n))]
    for i in range(n):
        t += [(1 + i, 2 + i, top(i + 1)), (1 + i, top(i + 1), top(i))]
    yield from extruded(p, t, 0, 15)

def sector(r0, r1, a0, a1, z0, z1, n=6):
    """A piece of a ring, closed."""
    ring = [(math.cos(a0 + (a1-a0)*i/n), math.sin(a0 + (a1-a0)*i/n)) for i in range(n + 1)]
    p = [(r1*c, r1*s) for c, s in ring] + [(r0*c, r0*s) for c, s in reversed(ring)]
    m = len(p)
    for i in range(n):
        for a, b, c in ((i, i + 1, m - 2 - i), (i, m - 2 - i, m - 1 - i)):
            a, b, c = p[a], p[b], p[c]
            yield (*a, z1, *b, z1, *c, z1)
            yield (*a, z0, *c, z0, *b, z0)
    for i in range(m):
        a, b = p[i], p[(i + 1) % m]
        yield (*a, z0, *b, z0, *b, z1)
        yield (*a, z0, *b, z1, *a, z1)

def stair(steps=16):
    """A spiral stair: steps of 3 mm around a column, each hanging in air but for its inner end."""
    yield from ((a*5, b*5, c, d*5, e*5, f, g*5, h*5, i) for a, b, c, d, e, f, g, h, i in cylinder(64, 1.0, 3.0*steps + 3))
    for k in range(steps):
        a = 2*math.pi*k/steps
        yield from sector(4.5, 20, a, a + 2*math.pi/steps*1.2, 3.0*k, 3.0*k + 3.0)

def cone_down(n=120, r0=3.0, r1=22.0, h=15.0):
    """A cone on its tip, blunt: its side leans out by 52 degrees from upright."""
    for i in range(n):
        (ca, sa), (cb, sb) = [(math.cos(2*math.pi*j/n), math.sin(2*math.pi*j/n)) for j in (i, i + 1)]
        yield (r0*ca, r0*sa, 0, r0*cb, r0*sb, 0, r1*cb, r1*sb, h)
        yield (r0*ca, r0*sa, 0, r1*cb, r1*sb, h, r1*ca, r1*sa, h)
        yield (0, 0, 0, r0*cb, r0*sb, 0, r0*ca, r0*sa, 0)
        yield (0, 0, h, r1*ca, r1*sa, h, r1*cb, r1*sb, h)

MODELS = {'benchy.stl': benchy, 'plate9_benchy.stl': plate9, 'knot_1M.stl': knot, 'sphere_1M.stl': sphere,
          'cyl_100k_tall.stl': cylinder, 'pins_1600.stl': pins, 'comb.stl': comb,
          'tee.stl': tee, 'arch.stl': arch, 'stair.stl': stair, 'cone_down.stl': cone_down}

def main():
    if len(sys.argv) < 2: sys.exit(__doc__)
    out = sys.argv[1]; os.makedirs(out, exist_ok=True)
    for name in sys.argv[2:] or MODELS:
        path = os.path.join(out, name)
        if 'benchy' in name and not os.path.exists(path) and not os.path.exists(benchy_path()):
            message = f'{name} left out: no {benchy_path()} (set BENCHY_3MF to the path of 3DBenchy.3mf)'
            if sys.argv[2:]: sys.exit(message)
            print(message, file=sys.stderr); continue
        if not os.path.exists(path): write(path, MODELS[name]())

main()
