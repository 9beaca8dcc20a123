#!/usr/bin/env python3
"""Writes models for measuring batches as STL files into a folder, and models.csv, which says what each is. Needs numpy.

usage: models.py OUT [--count 500] [--seed 1] [--broken 0.05] [--largest 1000000]

Triangles are drawn log-uniformly within four classes; the classes' shares are exact (largest remainders), so that the work in a folder
hardly depends on the seed. Of 500 models: 416 of 12 to 10 k triangles, 60 of 10 k to 100 k, 20 of 100 k to 400 k, 4 of 800 k to 1 M.
Shapes are by formula: boxes, stacked plates, plates with holes, tubes, gears, brackets, combs, vases, wavy domes, reliefs, knots; each a
closed surface (combs and stacks: overlapping ones), standing on its lowest point, within 250 x 210 x 200 mm, mostly 12 to 60 mm.
One in twenty of the small files is ASCII, the others are binary.
The share --broken of the models is broken, all among the small ones, in turn as BROKEN below lists: `repairable` ones have holes, turned
facets, facets twice or useless normals and are to be sliced; `refused` ones cannot be models: truncated, empty, NaN, text, no facets.
models.csv: name, kind, triangles, expected (ok | repairable | refused), bytes. Same arguments and numpy, same bytes.
"""
import argparse, csv, math, os
import numpy as np

TAU = 2 * math.pi
CLASSES = ((0.832, 12, 10_000), (0.12, 10_000, 100_000), (0.04, 100_000, 400_000), (0.008, 800_000, 1_000_000))
SMALL = 10_000

# Shapes. Each takes a random generator and the number of triangles wished, and gives corners (n, 3, 3) [mm], wound outward; closed but
# for rounding. They come near to the number, or to what the shape can have at least.

def quads(a, b, c, d):
    """Two triangles for each quadrilateral a b c d, seen from outside counter-clockwise; arrays (..., 3)."""
    a, b, c, d = np.broadcast_arrays(a, b, c, d)
    return np.stack([np.stack([a, b, c], -2), np.stack([a, c, d], -2)], -3).reshape(-1, 3, 3)

def closed_grid(p):
    """Facets of a grid of points (nu, nv, 3) that closes both ways; the first index runs along, the second around."""
    q, r = np.roll(p, -1, 0), np.roll(p, -1, 1)
    return quads(p, q, np.roll(q, -1, 1), r)

def boxes(list_of):
    """Facets of boxes x0 y0 z0 x1 y1 z1."""
    out = []
    for x0, y0, z0, x1, y1, z1 in list_of:
        p = np.array([(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)])
        out += [quads(*(p[i] for i in face)) for face in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))]
    return np.concatenate(out)

def rings(profile):
    """Facets of a tube (or any ring) whose cross-section runs around a closed curve: points (nu, nv, 3), nv along the section."""
    return closed_grid(profile)

def turned(radius, height, around, wave=None):
    """A body of revolution with a closed section: radius, height (nv); wave(angle, height) scales the radius."""
    a = np.arange(around) * TAU / around
    r = radius[None, :] * (np.ones((around, 1)) if wave is None else wave(a[:, None], height[None, :]))
    return np.stack([r * np.cos(a)[:, None], r * np.sin(a)[:, None], np.broadcast_to(height, r.shape)], -1)

def size(rng, low=12.0, high=60.0): return float(np.exp(rng.uniform(math.log(low), math.log(high))))

def box(rng, n):
    return boxes([(0, 0, 0, size(rng, 8, 50), size(rng, 8, 50), size(rng, 3, 25))])

def stack(rng, n):
    w, d, t, out, z = size(rng, 20, 60), size(rng, 20, 60), rng.uniform(2, 5), [], 0.0
    for k in range(max(1, min(12, n // 12))):
        f = 1 - 0.06 * k
        out.append((w * (1 - f) / 2, d * (1 - f) / 2, z - (0.5 if k else 0), w * (1 + f) / 2, d * (1 + f) / 2, z + t)); z += t
    return boxes(out)

def comb(rng, n):
    teeth = max(1, min(60, n // 12 - 1)); pitch = rng.uniform(2.2, 3.4); w = rng.uniform(0.9, 1.6); d = size(rng, 10, 40); h = size(rng, 6, 20)
    return boxes([(0, 0, 0, pitch * teeth + 1, d, 3)] + [(1 + pitch * k, 1, 2.5, 1 + pitch * k + w, d - 1, 2.5 + h) for k in range(teeth)])

def perforated(rng, n):
    """A plate of square cells, each with a round hole of `s` sides; s is a multiple of 8, so that cells share their edges' points."""
    s = 8 * max(1, min(12, int(math.sqrt(n) / 16)))
    cells = max(1, n // (6 * s)); nx = max(1, int(math.sqrt(cells * 1.3))); ny = max(1, round(cells / nx))
    pitch = min(size(rng, 7, 16), 230 / nx, 190 / ny); r = pitch * rng.uniform(0.2, 0.4); t = rng.uniform(2, 6)
    a = (np.arange(s) + 0.0) * TAU / s
    c, si = np.cos(a), np.sin(a)
    m = np.maximum(np.abs(c), np.abs(si))
    # Rounded to steps of the pitch, so that both cells at an edge have the very same points.
    square = np.round(np.stack([c / m, si / m], -1) * 4096) / 4096 * (pitch / 2)
    hole = np.stack([c, si], -1) * r
    out = []
    up = lambda p, z: np.concatenate([p, np.full(p.shape[:-1] + (1,), z)], -1)
    nxt = lambda p: np.roll(p, -1, 0)
    for i in range(nx):
        for j in range(ny):
            at = np.array([(i + 0.5) * pitch, (j + 0.5) * pitch]); sq, ho = square + at, hole + at
            out.append(quads(up(ho, t), up(sq, t), up(nxt(sq), t), up(nxt(ho), t)))
            out.append(quads(up(ho, 0), up(nxt(ho), 0), up(nxt(sq), 0), up(sq, 0)))
            out.append(quads(up(ho, 0), up(ho, t), up(nxt(ho), t), up(nxt(ho), 0)))
            mid = (square + nxt(square)) / 2; tol = pitch * 1e-3; half = pitch / 2
            for axis, sign, last in ((0, 1, i == nx - 1), (0, -1, i == 0), (1, 1, j == ny - 1), (1, -1, j == 0)):
                on = np.abs(mid[:, axis] - sign * half) < tol
                if last and on.any(): out.append(quads(up(sq[on], 0), up(nxt(sq)[on], 0), up(nxt(sq)[on], t), up(sq[on], t)))
    return np.concatenate(out)

def tube(rng, n):
    ro = size(rng, 6, 25); t = rng.uniform(1.2, 0.4 * ro); h = size(rng, 8, 50)
    s = max(6, min(n // 8, 1500)); steps = max(1, (n // s - 4) // 4)
    z = np.linspace(0, h, steps + 1)
    radius = np.concatenate([np.full(steps + 1, ro), np.full(steps + 1, ro - t)])
    return rings(turned(radius, np.concatenate([z, z[::-1]]), s))

def gear(rng, n):
    """Teeth by a rounded wave, a bore, straight or helical."""
    teeth = int(rng.integers(8, 40)); s = max(2 * teeth, min(n // 8, 4000)); steps = max(1, (n // s - 4) // 4)
    r = size(rng, 8, 30); m = 2 * r / teeth; bore = rng.uniform(0.2, 0.5) * r; h = rng.uniform(4, 14); turn = rng.uniform(-0.02, 0.02)
    z = np.linspace(0, h, steps + 1); a = np.arange(s) * TAU / s
    out = r + 0.45 * m * np.tanh(2.5 * np.sin(teeth * (a[:, None] + turn * z[None, :])))
    radius = np.concatenate([out, np.full((s, steps + 1), bore)], 1); height = np.concatenate([z, z[::-1]])
    return rings(np.stack([radius * np.cos(a)[:, None], radius * np.sin(a)[:, None], np.broadcast_to(height, radius.shape)], -1))

def bracket(rng, n):
    """A ribbon bent into an L, U or S with round corners, extruded."""
    kind = int(rng.integers(3)); t = rng.uniform(2, 5); leg = size(rng, 15, 45); depth = size(rng, 10, 40); r = rng.uniform(1.0, 2.0) * t
    turns = {0: [1], 1: [1, 1], 2: [1, -1]}[kind]; arc = max(1, min(200, (n // 8 - 2) // (2 * len(turns))))
    p, heading, line, normals = np.zeros(2), 0.0, [], []
    def put(): line.append(p.copy()); normals.append((-math.sin(heading), math.cos(heading)))
    put()
    for k, sign in enumerate([*turns, 0]):
        p = p + (leg if k != 1 else 0.7 * leg) * np.array([math.cos(heading), math.sin(heading)]); put()
        for _ in range(arc if sign else 0):
            centre = p + sign * r * np.array([-math.sin(heading), math.cos(heading)])
            heading += sign * math.pi / 2 / arc
            p = centre - sign * r * np.array([-math.sin(heading), math.cos(heading)]); put()
    line, normals = np.array(line), np.array(normals)
    left, right = line + normals * t / 2, line - normals * t / 2
    steps = max(1, (n // (2 * (len(line) + 1)) - 2) // 2)
    section = np.concatenate([right, left[::-1]])
    y = np.linspace(0, depth, steps + 1)
    at = lambda q, v: np.insert(q, 1, v, axis=-1)
    grid = np.stack([at(section, v) for v in y])
    around = np.roll(grid, -1, 1)
    sides = quads(grid[:-1], around[:-1], around[1:], grid[1:])
    cap = lambda v, a, b: quads(at(a[:-1], v), at(b[:-1], v), at(b[1:], v), at(a[1:], v))
    return np.concatenate([sides, cap(0.0, left, right)[:, ::-1], cap(depth, left, right)])

def vase(rng, n):
    """An open vessel with a wall of 1.6 mm and a floor; fluted and twisted."""
    h, r = size(rng, 25, 70), size(rng, 10, 26); lobes = int(rng.integers(0, 12)); depth = rng.uniform(0, 0.08); twist = rng.uniform(-0.03, 0.03)
    a, b = rng.uniform(0.1, 0.3), rng.uniform(2, 5)
    s = max(8, int(math.sqrt(n / 4 * 2.0))); rows = max(2, n // (4 * s))
    z = np.linspace(0, h, rows + 1); outer = r * (1 + a * np.sin(b * z / h)); inner = outer - 1.6
    return capped(s, np.concatenate([outer, inner[::-1]]), np.concatenate([z, np.maximum(z, 1.6)[::-1]]),
                  lambda ang, hh: 1 + depth * np.sin(lobes * (ang + twist * hh)))

def dome(rng, n):
    """A wavy egg on a flat foot."""
    r = size(rng, 8, 35); k, m = int(rng.integers(2, 14)), int(rng.integers(2, 14)); depth = rng.uniform(0.01, 0.06); tall = rng.uniform(0.7, 1.5)
    s = max(8, int(math.sqrt(n))); rows = max(3, n // (2 * s))
    t = np.linspace(-0.8, math.pi / 2 - 0.5 / rows, rows + 1)
    z = r * tall * (np.sin(t) - math.sin(-0.8))
    return capped(s, r * np.cos(t), z, lambda ang, hh: 1 + depth * np.sin(k * ang) * np.sin(m * hh / r))

def capped(around, radius, height, wave):
    """A body of revolution whose section begins and ends near the axis; the two ends are closed by fans."""
    p = turned(radius, height, around, wave); q = np.roll(p, -1, 0)
    side = quads(p[:, :-1], q[:, :-1], q[:, 1:], p[:, 1:])
    middle = lambda i: np.broadcast_to(np.array([0.0, 0.0, height[i]]), p[:, i].shape)
    return np.concatenate([side, np.stack([middle(0), q[:, 0], p[:, 0]], 1), np.stack([middle(-1), p[:, -1], q[:, -1]], 1)])

def relief(rng, n):
    """A plate with a wavy top."""
    w, d = size(rng, 25, 90), size(rng, 25, 90); m = max(2, int(math.sqrt(n / 4 * w / d))); k = max(2, n // (4 * m))
    x, y = np.meshgrid(np.linspace(0, w, m + 1), np.linspace(0, d, k + 1), indexing='ij')
    z = 3 + sum(rng.uniform(0.2, 0.6) * np.sin(rng.uniform(0.05, 1.2) * x + rng.uniform(0.05, 1.2) * y + rng.uniform(0, TAU)) for _ in range(5))
    top, bottom = np.stack([x, y, z], -1), np.stack([x, y, 0 * z], -1)
    out = [quads(top[:-1, :-1], top[1:, :-1], top[1:, 1:], top[:-1, 1:]), quads(bottom[:-1, :-1], bottom[:-1, 1:], bottom[1:, 1:], bottom[1:, :-1])]
    wall = lambda b, t: out.append(quads(b[:-1], b[1:], t[1:], t[:-1]))
    wall(bottom[:, 0], top[:, 0]); wall(bottom[-1], top[-1]); wall(bottom[::-1, -1], top[::-1, -1]); wall(bottom[0, ::-1], top[0, ::-1])
    return np.concatenate(out)

def knot(rng, n):
    """A torus knot (2, q) with a rippled tube."""
    q = 3 + 2 * int(rng.integers(0, 2)); big = size(rng, 14, 34); small, tube_r = 0.4 * big, rng.uniform(0.14, 0.2) * big * 3 / q
    along = max(24, int(math.sqrt(n / 2 * 8))); around = max(6, n // (2 * along))
    t = np.arange(along) * TAU / along
    centre = lambda u: np.stack([(big + small * np.cos(q * u)) * np.cos(2 * u), (big + small * np.cos(q * u)) * np.sin(2 * u), -1.5 * small * np.sin(q * u)], -1)
    c = centre(t); T = centre(t + 1e-4) - centre(t - 1e-4); T /= np.linalg.norm(T, axis=1)[:, None]
    up = c * [1, 1, 0]; N = up - (up * T).sum(1)[:, None] * T; N /= np.linalg.norm(N, axis=1)[:, None]; B = np.cross(T, N)
    a = np.arange(around)[None, :, None] * TAU / around
    r = tube_r * (1 + 0.03 * np.sin(6 * a) * np.sin(60 * t)[:, None, None])
    return closed_grid((c[:, None] + r * (np.cos(a) * N[:, None] + np.sin(a) * B[:, None])))

TINY = (box, stack, comb, tube)
SMALLER = (stack, comb, perforated, tube, gear, bracket, vase, dome, relief, knot)
LARGER = (perforated, gear, vase, dome, relief, knot)
LARGEST = (knot, dome, relief, vase)

# Files.

def outward(t):
    """Winds a closed surface so that its volume is positive, puts it onto the corner of the bed, rounds to float32."""
    volume = np.einsum('ij,ij->i', t[:, 0], np.cross(t[:, 1], t[:, 2])).sum()
    if volume < 0: t = t[:, ::-1]
    t = np.round(t - t.min((0, 1)), 5).astype('<f4')
    # What rounding made one point or line is no facet; its neighbours meet there.
    same = (t[:, 0] == t[:, 1]).all(1) | (t[:, 1] == t[:, 2]).all(1) | (t[:, 2] == t[:, 0]).all(1)
    return t[~same]

def normals(t):
    n = np.cross((t[:, 1] - t[:, 0]).astype('f8'), (t[:, 2] - t[:, 0]).astype('f8'))
    return (n / np.maximum(np.linalg.norm(n, axis=1), 1e-30)[:, None]).astype('<f4')

FACET = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('attribute', '<u2')])

def binary(t, n=None, count=None):
    f = np.zeros(len(t), FACET); f['normal'] = normals(t) if n is None else n; f['corners'] = t
    return b'model'.ljust(80) + np.uint32(len(t) if count is None else count).tobytes() + f.tobytes()

def ascii_text(t):
    rows = ['solid model']
    for n, (a, b, c) in zip(normals(t).tolist(), t.tolist()):
        v = ''.join(f'      vertex {x:.6g} {y:.6g} {z:.6g}\n' for x, y, z in (a, b, c))
        rows.append('  facet normal {:.6g} {:.6g} {:.6g}\n    outer loop\n'.format(*n) + v + '    endloop\n  endfacet')
    return '\n'.join([*rows, 'endsolid model', '']).encode()

def pick(rng, t, share): return rng.choice(len(t), max(1, min(len(t) - 1, int(len(t) * share))), replace=False)

def some_missing(rng, t): return binary(np.delete(t, pick(rng, t, 0.01), 0))
def some_turned(rng, t):
    t = t.copy(); k = pick(rng, t, 0.1); t[k] = t[k][:, ::-1]; return binary(t)
def some_twice(rng, t): return binary(np.concatenate([t, t[pick(rng, t, 0.05)]]))
def all_turned(rng, t): return binary(t[:, ::-1])
def no_normals(rng, t): return binary(t, np.full((len(t), 3), np.nan, '<f4'))
def cut_short(rng, t): b = binary(t); return b[:84 + int((len(b) - 84) * rng.uniform(0.2, 0.8))]
def empty(rng, t): return b''
def not_a_number(rng, t):
    t = t.copy(); t[int(rng.integers(len(t))), int(rng.integers(3)), int(rng.integers(3))] = np.nan; return binary(t)
def text(rng, t): return b'The model is in the other mail. ' * int(rng.integers(8, 200))
def no_facets(rng, t): return binary(t[:0])
def wrong_count(rng, t): return binary(t, count=len(t) * 1000 + 7)
def ascii_cut(rng, t): b = ascii_text(t[:200]); return b[:int(len(b) * rng.uniform(0.3, 0.9))]
def too_far(rng, t): t = t.copy(); t[0, 0, 0] = 3e38; return binary(t)

BROKEN = ((some_missing, 'repairable'), (cut_short, 'refused'), (some_turned, 'repairable'), (not_a_number, 'refused'), (some_twice, 'repairable'),
          (empty, 'refused'), (all_turned, 'repairable'), (text, 'refused'), (no_normals, 'repairable'), (wrong_count, 'refused'),
          (ascii_cut, 'refused'), (no_facets, 'refused'), (too_far, 'refused'))

def shares(count, weights):
    """`count` in parts by weight, by largest remainders."""
    exact = [count * w / sum(weights) for w in weights]; parts = [int(e) for e in exact]
    for i in sorted(range(len(parts)), key=lambda i: parts[i] - exact[i])[:count - sum(parts)]: parts[i] += 1
    return parts

def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument('out'); ap.add_argument('--count', type=int, default=500); ap.add_argument('--seed', type=int, default=1)
    ap.add_argument('--broken', type=float, default=0.05); ap.add_argument('--largest', type=int, default=1_000_000, help='leave out classes above')
    a = ap.parse_args()
    os.makedirs(a.out, exist_ok=True)
    rng = np.random.default_rng([a.seed, 0])
    classes = [c for c in CLASSES if c[2] <= max(a.largest, SMALL)]
    wanted = []
    for parts, (_, low, high) in zip(shares(a.count, [c[0] for c in classes]), classes):
        # One in each of as many equal steps of the logarithm: no lumps.
        u = (np.arange(parts) + rng.uniform(0, 1, parts)) / max(1, parts)
        wanted += np.exp(math.log(low) + u * math.log(high / low)).astype(int).tolist()
    wanted = [wanted[i] for i in rng.permutation(len(wanted))]
    small = [i for i, n in enumerate(wanted) if n <= SMALL]
    broken = set(rng.choice(small, min(len(small), round(a.count * a.broken)), replace=False).tolist())
    shape_of, turn = {}, {}
    rows, damaged = [], 0
    for i, n in enumerate(wanted):
        own = np.random.default_rng([a.seed, 1, i])
        family = TINY if n < 100 else SMALLER if n <= SMALL else LARGER if n <= 400_000 else LARGEST
        # Shapes in turn, so that each has its share.
        shape = family[turn.setdefault(family, 0) % len(family)]; turn[family] += 1
        t = outward(shape(own, n)); kind, expected, triangles = shape.__name__, 'ok', len(t)
        if i in broken:
            damage, expected = BROKEN[damaged % len(BROKEN)]; damaged += 1
            data, kind = damage(own, t), f'{kind}, {damage.__name__.replace("_", " ")}'
        elif n <= SMALL and own.uniform() < 0.05: data, kind = ascii_text(t), kind + ', ascii'
        else: data = binary(t)
        name = f'{i:0{len(str(a.count - 1))}d}_{kind.split(",")[0]}_{triangles}.stl'
        with open(os.path.join(a.out, name + '.part'), 'wb') as f: f.write(data)
        os.replace(os.path.join(a.out, name + '.part'), os.path.join(a.out, name))
        rows.append((name, kind, triangles, expected, len(data)))
    with open(os.path.join(a.out, 'models.csv'), 'w', newline='') as f:
        w = csv.writer(f, lineterminator='\n'); w.writerow(('name', 'kind', 'triangles', 'expected', 'bytes')); w.writerows(rows)
    print(f'{len(rows)} models, {sum(r[2] for r in rows) / 1e6:.2f} M triangles, {sum(r[4] for r in rows) / 1e6:.0f} MB; ' +
          ', '.join(f'{sum(r[3] == e for r in rows)} {e}' for e in ('ok', 'repairable', 'refused')))

main()
