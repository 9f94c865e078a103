#!/usr/bin/env python3
"""Draws the pictures of the joints: `python3 draw.py` writes one SVG for each beside this file.

Blue is the parent and what it carries, orange is the frame that hangs on the joint; axes are dash-dotted,
and what the joint releases is green with its name.
"""

from math import atan2, cos, hypot, pi, sin, tau
from pathlib import Path

SCALE, WIDTH, HEIGHT = 46.0, 260, 180
BLUE, ORANGE, GREEN, INK = ("#bcd7ec", "#0a4f80"), ("#f7cfa6", "#a5490a"), "#00805c", "#505050"
TURN, TILT = 0.55, 0.42  # the viewer stands to the right of -e2 and above


def add(a, b, k=1.0):
    return tuple(x + k * y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return tuple(x / dot(a, a) ** 0.5 for x in a)


RIGHT = (cos(TURN), sin(TURN), 0.0)
TOWARDS = (sin(TURN) * cos(TILT), -cos(TURN) * cos(TILT), sin(TILT))
UP = cross(TOWARDS, RIGHT)
X, Y, Z, O = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)


def across(e):
    """Two unit vectors across an axis."""
    a = unit(cross(e, min((X, Y, Z), key=lambda k: abs(dot(k, e)))))
    return a, cross(e, a)


def circle(p, e, r, start=0.0, end=tau, n=48):
    a, b = across(unit(e))
    steps = [start + (end - start) * k / n for k in range(n + 1)]
    return [add(add(p, a, r * cos(s)), b, r * sin(s)) for s in steps]


def hull(points):
    points = sorted(set(points))

    def half(points):
        out = []
        for p in points:
            while len(out) > 1 and (out[-1][0] - out[-2][0]) * (p[1] - out[-2][1]) <= (
                out[-1][1] - out[-2][1]
            ) * (p[0] - out[-2][0]):
                out.pop()
            out.append(p)
        return out[:-1]

    return half(points) + half(points[::-1])


class Picture:
    def __init__(self, middle=O):
        self.middle, self.items = middle, []

    def at(self, p):
        p = add(p, self.middle, -1.0)
        return (
            round(WIDTH / 2 + SCALE * dot(p, RIGHT), 1),
            round(HEIGHT / 2 - SCALE * dot(p, UP), 1),
        )

    def path(self, flat, style, closed=False):
        text = "M" + "L".join(f"{x:g} {y:g}" for x, y in flat) + ("Z" if closed else "")
        self.items.append(f'<path d="{text}" {style}/>')

    def line(self, points, colour=INK, width=1.2, more=""):
        self.path([self.at(p) for p in points], f'fill="none" stroke="{colour}" stroke-width="{width}" {more}'.rstrip())

    def face(self, points, colour):
        style = f'fill="{colour[0]}" stroke="{colour[1]}" stroke-width="1"'
        self.path([self.at(p) for p in points], style, True)

    def solid(self, ends, colour):
        """A prism: silhouette of both ends, and the end that is seen."""
        flat = hull([self.at(p) for end in ends for p in end])
        self.path(flat, f'fill="{colour[0]}" stroke="{colour[1]}" stroke-width="1"', True)
        self.face(ends[-1], colour)

    def rod(self, p, q, r, colour, n=48):
        """A round bar from p to q."""
        e = unit(add(q, p, -1.0))
        ends = [circle(p, e, r, n=n)[:-1], circle(q, e, r, n=n)[:-1]]
        self.solid(ends if dot(e, TOWARDS) > 0 else ends[::-1], colour)

    def box(self, centre, half, colour, axes=(X, Y, Z)):
        """A block with half its sides along three axes."""
        for k in range(3):
            e, a, b = axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]
            s = 1.0 if dot(e, TOWARDS) > 0 else -1.0
            c = add(centre, e, s * half[k])
            a, b = tuple(x * half[(k + 1) % 3] for x in a), tuple(x * half[(k + 2) % 3] for x in b)
            corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
            self.face([add(add(c, a, i), b, j) for i, j in corners], colour)

    def ball(self, p, r, colour):
        x, y = self.at(p)
        self.items.append(
            f'<circle cx="{x:g}" cy="{y:g}" r="{SCALE * r:.1f}" fill="{colour[0]}" stroke="{colour[1]}" stroke-width="1"/>'
        )

    def axis(self, p, q):
        self.line([p, q], INK, 1, 'stroke-dasharray="9 3 2 3"')

    def arrow(self, points, both=False):
        """A green arrow along points."""
        self.line(points, GREEN, 2)
        for tip, back in [(points[-1], points[-2])] + ([(points[0], points[1])] if both else []):
            (x, y), (u, v) = self.at(tip), self.at(back)
            d = atan2(y - v, x - u)
            corner = [(x + 4 * cos(d), y + 4 * sin(d))]
            corner += [(x - 6 * cos(d + s), y - 6 * sin(d + s)) for s in (0.6, -0.6)]
            self.path([(round(a, 1), round(b, 1)) for a, b in corner], f'fill="{GREEN}"', True)

    def label(self, text, p, dx=0, dy=0, colour=GREEN, anchor="middle"):
        x, y = self.at(p)
        self.items.append(f'<text x="{x + dx:g}" y="{y + dy:g}" text-anchor="{anchor}" fill="{colour}">{text}</text>')

    def write(self, name, title):
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}"'
            ' font-family="sans-serif" font-size="13" stroke-linejoin="round" stroke-linecap="round">'
        )
        ground = f'<rect width="{WIDTH}" height="{HEIGHT}" rx="6" fill="#ffffff"/>'
        lines = [head, f"<title>{title}</title>", ground, *self.items, "</svg>", ""]
        (Path(__file__).parent / f"{name}.svg").write_text("\n".join(lines))


def offset():
    p = Picture()
    p.rod((-1.3, 0, -0.2), (1.3, 0, 0.5), 0.07, ("#e8e8e8", INK))
    p.box((-1.5, 0, -0.25), (0.4, 0.35, 0.35), BLUE)
    p.box((1.5, 0, 0.55), (0.4, 0.35, 0.35), ORANGE)
    p.label("parent", (-1.5, 0, -0.25), 0, 44, BLUE[1])
    p.label("position", (1.5, 0, 0.55), 0, -32, ORANGE[1])
    p.write("offset", "Rigid link: a frame fixed to its parent at another position")


def weld():
    p = Picture()
    p.box((-0.75, 0, 0), (0.75, 0.5, 0.45), BLUE)
    p.box((0.75, 0, 0), (0.75, 0.5, 0.45), ORANGE)
    seam = [(0, 0.5, 0.45), (0, -0.5, 0.45), (0, -0.5, -0.45)]
    p.line(seam, INK, 6)
    p.label("nothing released", O, 0, 66, INK)
    p.write("weld", "Weld: a frame at the position of its parent")


def revolute():
    p = Picture()
    p.axis((0, 1.6, 0), O)
    p.rod((0, 0.75, 0), (0, 0.3, 0), 0.42, BLUE)
    p.box((-1.15, 0.52, 0), (0.75, 0.2, 0.16), BLUE)
    p.rod((0, 0.3, 0), (0, -0.3, 0), 0.42, ORANGE)
    p.box((0.99, 0.0, 0.57), (0.72, 0.2, 0.16), ORANGE, ((cos(0.52), 0, sin(0.52)), Y, (-sin(0.52), 0, cos(0.52))))
    p.rod((0, -0.3, 0), (0, -0.75, 0), 0.42, BLUE)
    p.rod((0, -0.75, 0), (0, -0.85, 0), 0.16, BLUE)
    p.axis((0, -0.85, 0), (0, -1.9, 0))
    p.label("axis", (0, -1.9, 0), -20, 4, INK)
    arc = [(1.9 * cos(s), 0, 1.9 * sin(s)) for s in [0.5 * k / 20 - 0.18 for k in range(21)]]
    p.arrow(arc)
    p.label("angle", arc[4], 24, 10)
    p.write("revolute", "Revolute joint: an angle about an axis")


def spherical():
    p = Picture((0, 0, 0.1))
    e = unit((1.3, 0, 0.5))
    p.axis(O, (0, 0, 1.5))
    p.box((-1.35, 0, 0), (0.7, 0.22, 0.22), BLUE)
    p.ball(O, 0.72, BLUE)
    p.ball((0.05, -0.05, 0.03), 0.5, ORANGE)
    p.rod(tuple(0.3 * x for x in e), tuple(1.7 * x for x in e), 0.14, ORANGE)
    p.axis((0, -0.5, 0), (0, -1.9, 0))
    p.axis(tuple(1.7 * x for x in e), tuple(2.3 * x for x in e))
    p.arrow(circle((0, 0, 1.15), Z, 0.35, 2.6, 6.6))
    p.arrow(circle((0, -1.4, 0), Y, 0.35, 0.5, 4.6))
    p.arrow(circle(tuple(1.45 * x for x in e), e, 0.36, 1.9, 5.9))
    p.label("rotation", (0, 0, 1.15), -52, 2)
    p.write("spherical", "Spherical joint: all rotations")


def fork(p, e, pin, colour, reach):
    """A shaft along e that ends in a fork about the origin, its prongs on the axis `pin`."""
    side = cross(e, pin)
    far = 1 if dot(pin, TOWARDS) < 0 else -1
    axes = (e, pin, side)
    p.rod(tuple(reach * x for x in e), tuple(0.95 * x for x in e), 0.2, colour)
    p.box(add(tuple(0.85 * x for x in e), pin, 0), (0.12, 0.62, 0.2), colour, axes)
    for s in (far, -far):
        p.box(add(tuple(0.32 * x for x in e), pin, 0.5 * s), (0.42, 0.12, 0.2), colour, axes)


def universal():
    p = Picture((0.1, 0, 0.1))
    e = unit((cos(0.45), 0.0, sin(0.45)))
    p.axis((0, 0, 1.4), (0, 0, -1.4))
    p.axis((0, 1.5, 0), (0, -1.7, 0))
    fork(p, (-1.0, 0, 0), Z, BLUE, 2.3)
    p.rod((0, 0, -0.62), (0, 0, 0.62), 0.1, ("#e8e8e8", INK))
    p.rod((0, 0.62, 0), (0, -0.62, 0), 0.1, ("#e8e8e8", INK))
    fork(p, e, Y, ORANGE, 2.2)
    p.arrow(circle((0, 0, 1.15), Z, 0.4, 2.6, 6.6))
    p.label("angle 1", (0, 0, 1.15), -44, -2)
    p.arrow(circle((0, -1.35, 0), Y, 0.4, 0.5, 4.6))
    p.label("angle 2", (0, -1.35, 0), -44, 18)
    p.write("universal", "Universal joint: angles about two crossed axes")


def constant_velocity():
    p = Picture((0, 0, 0.1))
    e = (cos(0.5), 0.0, sin(0.5))
    p.axis((-2.4, 0, 0), (2.4, 0, 0))
    p.rod((-2.2, 0, 0), (-0.5, 0, 0), 0.2, BLUE)
    p.ball(O, 0.66, BLUE)
    p.ball((0.08, -0.05, 0.04), 0.44, ORANGE)
    p.rod((0.25 * e[0], 0, 0.25 * e[2]), (2.2 * e[0], 0, 2.2 * e[2]), 0.2, ORANGE)
    p.arrow([(2.15 * cos(s), 0, 2.15 * sin(s)) for s in [0.42 * k / 12 for k in range(13)]])
    p.label("tilt 1", (2.15, 0, 0.3), 30, 12)
    p.arrow([(1.7 * cos(s), -1.7 * sin(s), 0) for s in [0.75 * k / 12 for k in range(13)]])
    p.label("tilt 2", (1.7 * cos(0.75), -1.7 * sin(0.75), 0), -6, 20)
    for x, f in ((-1.8, X), (1.8, e)):
        c = (x, 0, 0) if x < 0 else tuple(1.35 * k for k in e)
        p.line(circle(c, f, 0.42, 2.4, 6.0)[:], INK, 1.2)
    p.label("equal speeds", (-1.7, 0, 0), 0, 46, INK)
    p.write("constant_velocity", "Constant-velocity joint: two tilts of shafts that turn equally fast")


def sleeve(p, n, half=0.55, r=0.42):
    p.rod((half, 0, 0), (-half, 0, 0), r, ORANGE, n)


def cylindrical():
    p = Picture()
    p.axis((2.6, 0, 0), (-2.6, 0, 0))
    p.rod((-0.5, 0, 0), (-2.0, 0, 0), 0.2, BLUE)
    p.rod((-0.55, 0, 0), (0.55, 0, 0), 0.42, ORANGE)
    p.rod((0.55, 0, 0), (2.0, 0, 0), 0.2, BLUE)
    p.arrow([(-0.7, 0, 0.95), (0.9, 0, 0.95)])
    p.label("displacement", (0.1, 0, 0.95), 30, -16)
    p.arrow(circle((1.25, 0, 0), X, 0.52, 2.2, 6.2))
    p.label("angle", (1.25, 0, -0.5), 12, 26)
    p.write("cylindrical", "Cylindrical joint: a displacement along an axis and an angle about it")


def prismatic():
    p = Picture()
    p.axis((2.6, 0, 0), (-2.6, 0, 0))
    p.box((-1.3, 0, 0), (0.9, 0.2, 0.2), BLUE)
    p.box((0, 0, 0), (0.55, 0.42, 0.42), ORANGE)
    p.box((1.3, 0, 0), (0.75, 0.2, 0.2), BLUE)
    p.arrow([(-0.7, 0, 0.95), (0.9, 0, 0.95)])
    p.label("displacement", (0.1, 0, 0.95), 30, -16)
    p.write("prismatic", "Prismatic joint: a displacement along an axis")


def planar():
    p = Picture((0, 0, 0.2))
    p.face([(-1.7, -1.2, 0), (1.7, -1.2, 0), (1.7, 1.6, 0), (-1.7, 1.6, 0)], BLUE)
    p.arrow([(0, 0, 0), (1.5, 0, 0)])
    p.arrow([(0, 0, 0), (0, 1.45, 0)])
    p.box((0, 0, 0.2), (0.38, 0.28, 0.2), ORANGE)
    p.axis((0, 0, 0.4), (0, 0, 1.7))
    p.arrow(circle((0, 0, 1.15), Z, 0.35, 2.6, 6.8))
    p.label("displacement 1", (1.5, 0, 0), 18, 28)
    p.label("displacement 2", (0, 1.3, 0), 38, -16)
    p.label("angle", (0, 0, 1.15), -42, 4)
    p.label("normal", (0, 0, 1.7), 28, 8, INK)
    p.write("planar", "Planar joint: two displacements in a plane, an angle about its normal")


def helical():
    p = Picture()
    p.axis((2.6, 0, 0), (-2.6, 0, 0))
    pitch = 0.3

    def thread(start, end):
        p.rod((start, 0, 0), (end, 0, 0), 0.26, BLUE)
        k = 0
        while start + (k + 1) * pitch <= end:
            a, b = across(X)
            points = []
            for j in range(25):
                s = pi * j / 24 + atan2(dot(TOWARDS, b), dot(TOWARDS, a)) - pi / 2
                x = start + (k + 0.25 + 0.5 * j / 24) * pitch
                points.append(add(add((x, 0, 0), a, 0.26 * cos(s)), b, 0.26 * sin(s)))
            p.line(points, BLUE[1], 1)
            k += 1

    thread(-2.0, -0.4)
    p.rod((-0.4, 0, 0), (0.4, 0, 0), 0.52, ORANGE, 6)
    thread(0.4, 2.0)
    p.arrow(circle((0.75, 0, 0), X, 0.66, 2.2, 6.4))
    p.label("angle", (0.75, 0, -0.66), 6, 26)
    p.label("pitch in a turn", (-1.2, 0, 0.6), 0, -12, INK)
    p.write("helical", "Helical joint: the angle of a screw")


def on_curve():
    p = Picture((0, 0, 0.0))

    def at(s):
        return (s, 0.9 * sin(1.3 * s), 0.5 * sin(2.1 * s + 0.4))

    p.line([at(-2.1 + 4.2 * k / 80) for k in range(81)], BLUE[1], 3)
    p.arrow([add(at(0.25 + 0.85 * k / 12), (0, 0, 0.22)) for k in range(13)])
    p.label("parameter", at(0.8), -10, -28)
    p.box(at(0.0), (0.24, 0.24, 0.24), ORANGE, (unit((0.8, 0.5, 0.3)), *across(unit((0.8, 0.5, 0.3)))))
    p.arrow(circle(at(0.0), Z, 0.55, 4.2, 6.0))
    p.label("rotation", at(0.0), 6, 44)
    p.write("on_curve", "Point on a curve: the parameter, and all rotations")


def on_surface():
    p = Picture((0, 0, 0.1))

    def at(u, v):
        return (u, v, 0.16 * u * u - 0.25 * v * v)

    grid = [-1.6 + 3.2 * k / 24 for k in range(25)]
    edge = [at(u, -1.2) for u in grid] + [at(1.6, -1.2 + 2.4 * k / 24) for k in range(25)]
    edge += [at(u, 1.2) for u in grid[::-1]] + [at(-1.6, 1.2 - 2.4 * k / 24) for k in range(25)]
    p.face(edge, BLUE)
    for k in range(1, 6):
        u, v = -1.6 + 3.2 * k / 6, -1.2 + 2.4 * k / 6
        p.line([at(u, -1.2 + 2.4 * j / 24) for j in range(25)], BLUE[1], 0.5)
        p.line([at(x, v) for x in grid], BLUE[1], 0.5)
    p.arrow([at(1.3 * k / 12, 0) for k in range(13)])
    p.arrow([at(0, -1.0 * k / 12) for k in range(13)])
    p.box((0, 0, 0.1), (0.24, 0.24, 0.24), ORANGE)
    p.label("parameter 1", at(1.3, 0), 8, -20)
    p.label("parameter 2", at(0, -1.0), -40, 26)
    p.label("rotation", (0, 0, 0.3), -56, -34)
    p.axis((0, 0, 0.2), (0, 0, 1.2))
    p.arrow(circle((0, 0, 0.8), Z, 0.35, 2.6, 6.6))
    p.write("on_surface", "Point on a surface: two parameters, and all rotations")


def slide():
    p = Picture()

    def at(s):
        return (s, 0, 0.32 * sin(1.1 * s + 0.3) - 0.1)

    for start, end in ((-2.2, 0.0), (0.0, 2.2)):
        points = [at(start + (end - start) * k / 40) for k in range(41)]
        p.line(points, BLUE[1], 9)
        p.line(points, BLUE[0], 7)
    for s in (-2.2, -1.1, 1.1, 2.2):
        x, y = p.at(at(s))
        p.items.append(f'<circle cx="{x:g}" cy="{y:g}" r="3" fill="#ffffff" stroke="{INK}"/>')
    e = unit(add(at(0.05), at(-0.05), -1.0))
    p.rod(add(at(0), e, -0.4), add(at(0), e, 0.4), 0.26, ORANGE)
    p.arrow([add(at(-0.2 + 1.3 * k / 12), (0, 0, 0.5)) for k in range(13)])
    p.label("arc_length", add(at(0.5), (0, 0, 0.5)), 0, -10)
    p.write("slide", "Slide: the arc length along a chain of beam elements")


def wheel(p, centre, r, teeth, colour, phase=0.0, thick=0.25):
    shape = []
    for k in range(teeth):
        for part, height in ((0.0, -0.05), (0.2, 0.05), (0.5, 0.05), (0.7, -0.05)):
            s = tau * (k + part) / teeth + phase
            shape.append((centre[0] + (r + height) * cos(s), centre[1], centre[2] + (r + height) * sin(s)))
    back, front = [add(q, Y, thick) for q in shape], shape
    p.face(back, colour)
    p.solid([back, front], colour)
    p.rod(add(centre, Y, -0.01), add(centre, Y, -0.18), 0.1, ("#ffffff", INK))
    p.axis(add(centre, Y, -0.18), add(centre, Y, -0.7))


def arc_y(centre, r, start, end):
    return [(centre[0] + r * cos(s), centre[1] - 0.05, centre[2] + r * sin(s)) for s in [start + (end - start) * k / 24 for k in range(25)]]


def gear():
    p = Picture((0.05, 0, 0))
    a, b = (-0.62, 0, 0), (0.98, 0, 0)
    wheel(p, a, 1.0, 20, BLUE, 0.0)
    wheel(p, b, 0.6, 12, ORANGE, tau / 24 * 1.3)
    p.arrow(arc_y(a, 0.7, 0.7, 2.3))
    p.arrow(arc_y(b, 0.36, 2.6, 0.6))
    p.label("parent's angle", a, -10, 66)
    p.label("angle", b, 12, 54)
    p.write("gear", "Gear: an angle in a fixed ratio to another")


def rack():
    p = Picture((0, 0, -0.25))
    teeth, r = 18, 0.86
    top = []
    step = tau * r / teeth
    for k in range(-6, 7):
        for part, height in ((0.0, -0.05), (0.2, 0.05), (0.5, 0.05), (0.7, -0.05)):
            top.append(((k + part) * step, 0, -0.86 + height))
    shape = top + [(top[-1][0] + 0.1, 0, -0.91), (top[-1][0] + 0.1, 0, -1.2), (top[0][0], 0, -1.2)]
    p.face([add(q, Y, 0.25) for q in shape], ORANGE)
    p.solid([[add(q, Y, 0.25) for q in shape], shape], ORANGE)
    p.face(shape, ORANGE)
    wheel(p, (0, 0, 0.06), r, teeth, BLUE, -tau / 4 + tau / teeth * 0.85)
    p.arrow(arc_y((0, 0, 0.06), 0.55, 2.4, 0.7))
    p.label("parent's angle", (0, 0, 1.1), -76, 8)
    p.arrow([(0.3, 0, -1.45), (-1.0, 0, -1.45)])
    p.label("displacement", (-0.4, 0, -1.45), -8, 18)
    p.write("rack", "Rack and pinion: a displacement in proportion to an angle")


for draw in (offset, weld, revolute, spherical, universal, constant_velocity, cylindrical, prismatic,
             planar, helical, on_curve, on_surface, slide, gear, rack):
    draw()
