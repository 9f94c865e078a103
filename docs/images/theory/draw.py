"""Draws frames.svg and charts.svg of docs/theory.md: python3 docs/images/theory/draw.py"""

from math import cos, pi, radians, sin
from pathlib import Path

BLUE, ORANGE, GREEN, INK, GREY = "#0072b2", "#d55e00", "#009e73", "#282828", "#8c8c8c"
HERE = Path(__file__).parent


class Drawing:
    def __init__(self, width, height):
        self.width, self.height, self.items = width, height, []

    def line(self, points, colour=INK, width=1.4, dash="", arrow=False):
        path = " ".join(f"{'ML'[k > 0]}{x:.1f} {y:.1f}" for k, (x, y) in enumerate(points))
        end = f' marker-end="url(#{colour[1:]})"' if arrow else ""
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.items.append(f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}"{dashes}{end}/>')

    def circle(self, x, y, r, colour=INK, fill="none", dash=""):
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.items.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r}" fill="{fill}" stroke="{colour}" stroke-width="1.2"{dashes}/>')

    def text(self, x, y, words, colour=INK, anchor="start", style="", size=14):
        self.items.append(f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" '
                          f'font-size="{size}"{style}>{words}</text>')

    def frame(self, at, turn, colour, size, names=None):
        """Three axes at a point of the page, turned by a rotation matrix and seen from above."""
        for k in range(3):
            tip = project([turn[i][k] * size for i in range(3)])
            end = (at[0] + tip[0], at[1] + tip[1])
            self.line([at, end], colour, 2, arrow=True)
            if names:
                length = (tip[0] ** 2 + tip[1] ** 2) ** 0.5
                self.text(end[0] + 14 * tip[0] / length, end[1] + 14 * tip[1] / length + 5, names[k], colour, "middle")
        self.circle(*at, 3, colour, colour)

    def write(self, name):
        marks = "".join(
            f'<marker id="{c[1:]}" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="9" markerHeight="9" '
            f'markerUnits="userSpaceOnUse" orient="auto"><path d="M0 1L10 5L0 9z" fill="{c}"/></marker>'
            for c in (BLUE, ORANGE, GREEN, INK, GREY))
        head = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" '
                f'width="{self.width}" height="{self.height}" font-family="sans-serif">')
        lines = [head, f"<defs>{marks}</defs>", f'<rect width="{self.width}" height="{self.height}" fill="#ffffff"/>']
        (HERE / name).write_text("\n".join(lines + self.items + ["</svg>"]) + "\n")


def project(v):
    """Oblique view: e1 to the lower left, e2 to the right, e3 up."""
    x, y, z = v
    return (y - 0.55 * x, -z + 0.42 * x)


def rotation(axis, angle):
    """Rodrigues' formula."""
    length = sum(a * a for a in axis) ** 0.5
    a, b, c = (u / length for u in axis)
    s, v = sin(angle), 1 - cos(angle)
    return [[1 - v * (b * b + c * c), v * a * b - s * c, v * a * c + s * b],
            [v * a * b + s * c, 1 - v * (a * a + c * c), v * b * c - s * a],
            [v * a * c - s * b, v * b * c + s * a, 1 - v * (a * a + b * b)]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


ONE = rotation([0, 0, 1], 0)


def vector(drawing, a, b, words, at, colour=INK):
    """An arrow that ends short of the point at its tip."""
    length = ((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5
    end = [b[k] - 6 * (b[k] - a[k]) / length for k in range(2)]
    drawing.line([a, end], colour, 1.3, "5 3", arrow=True)
    drawing.text(*at, words, colour)


def child_of(symbol):
    return f'{symbol}<tspan font-size="10" dy="4">c</tspan><tspan dy="-4">&#8203;</tspan>'


def frames():
    drawing = Drawing(860, 330)
    bold = ' font-weight="bold"'
    drawing.text(20, 28, "A node", style=bold)
    drawing.text(450, 28, "A joint", style=bold)
    names = ["e₁", "e₂", "e₃"]
    origin, reference, current = (70, 270), (150, 130), (320, 110)
    drawing.frame(origin, ONE, INK, 50, names)
    drawing.frame(reference, ONE, GREY, 45)
    drawing.frame(current, rotation([1, 0.2, 0.9], 0.7), BLUE, 50)
    vector(drawing, origin, reference, "X", (92, 205))
    vector(drawing, reference, current, "d", (232, 112), GREEN)
    vector(drawing, origin, current, "x = X + d", (215, 205))
    drawing.text(150, 74, "reference", GREY, "middle", size=13)
    drawing.text(335, 165, "R(Ψ)", BLUE, "middle")
    drawing.text(335, 184, "current", BLUE, "middle", size=13)

    R = rotation([1, 0.35, -0.4], 0.5)
    Q = rotation([0, 0, 1], 0.6)
    origin, parent, child = (490, 270), (600, 120), (760, 150)
    drawing.frame(origin, ONE, INK, 50, names)
    drawing.frame(parent, R, BLUE, 50)
    drawing.frame(child, product(R, Q), ORANGE, 50)
    vector(drawing, origin, parent, "x", (528, 195))
    vector(drawing, parent, child, "R c(t, q)", (665, 118), GREEN)
    vector(drawing, origin, child, f"{child_of('x')} = x + R c", (640, 238))
    drawing.text(585, 170, "R", BLUE, "middle")
    drawing.text(585, 189, "parent", BLUE, "middle", size=13)
    drawing.text(735, 206, f"{child_of('R')} = R Q(t, q)", ORANGE)
    drawing.text(775, 225, "child", ORANGE, "middle", size=13)
    drawing.write("frames.svg")


def charts():
    drawing = Drawing(860, 360)
    bold = ' font-weight="bold"'
    # Left: the ball of rotation vectors, cut.
    drawing.text(20, 28, "Rotation vectors", style=bold)
    cx, cy, unit = 190, 195, 130 / (2 * pi)
    drawing.circle(cx, cy, 130, GREY, "#f0f6fb")
    drawing.circle(cx, cy, 65, INK, "none", "5 3")
    drawing.text(cx + 98, cy + 108, "ψ = 2π", GREY)
    drawing.text(cx, cy + 82, "ψ = π", INK, "middle")
    drawing.circle(cx, cy, 2.5, INK, INK)
    drawing.text(cx + 7, cy + 16, "0", INK)

    def at(angle, degrees):
        turn = radians(degrees)
        return (cx + unit * angle * cos(turn), cy - unit * angle * sin(turn))

    # A motion: the vector grows to 4 along a curve, its complement takes over.
    path = [(0.08 * k, 52 - 10 * sin(0.35 * 0.08 * k)) for k in range(51)]
    inner = [p for p in path if p[0] <= 3.6]
    drawing.line([at(*p) for p in inner], BLUE, 2, arrow=True)
    angle, degrees = inner[-1]
    here, there = at(angle, degrees), at(angle - 2 * pi, degrees)
    drawing.line([here, there], GREY, 1.2, "2 3")
    rest = [(a - 2 * pi, d) for a, d in ((angle + 0.08 * k, degrees - 0.6 * k) for k in range(25))]
    drawing.line([at(*p) for p in rest], ORANGE, 2, arrow=True)
    drawing.circle(*here, 3, BLUE, BLUE)
    drawing.circle(*there, 3, ORANGE, ORANGE)
    drawing.text(here[0] + 8, here[1] - 6, "Ψ", BLUE)
    drawing.text(there[0] - 8, there[1] + 16, "Ψᶜ", ORANGE, "end")

    # Right: rotation about a fixed axis.
    drawing.text(450, 28, "Rotation by an angle θ about a fixed axis", style=bold)
    x0, y0, ux, uy = 500, 195, 26, 20
    place = lambda theta, psi: (x0 + ux * theta, y0 - uy * psi)
    drawing.line([(x0, y0 + 145), (x0, y0 - 145)], INK, 1.2, arrow=True)
    drawing.line([(x0, y0), (x0 + 12.4 * ux, y0)], INK, 1.2, arrow=True)
    drawing.text(x0 + 12.3 * ux, y0 - 10, "θ", INK, "end")
    drawing.text(x0 + 8, y0 - 138, "component along the axis", INK, size=13)
    for psi, name in ((2 * pi, "2π"), (pi, "π"), (-pi, "−π"), (-2 * pi, "−2π")):
        drawing.line([place(0, psi), place(11.6, psi)], GREY, 0.8, "2 3")
        drawing.text(x0 - 8, place(0, psi)[1] + 5, name, INK, "end")
    drawing.line([place(pi, pi), place(2 * pi - 0.05, 2 * pi)], BLUE, 1.2, "5 3")
    drawing.line([place(0, 0), place(pi, pi)], BLUE, 2.2)
    drawing.line([place(0.05, -2 * pi), place(pi, -pi)], ORANGE, 1.2, "5 3")
    drawing.line([place(pi, -pi), place(3 * pi, pi)], ORANGE, 2.2)
    drawing.line([place(3 * pi, -pi), place(3.6 * pi, -0.4 * pi)], BLUE, 2.2)
    for k in (1, 3):
        drawing.line([place(k * pi, pi), place(k * pi, -pi + 0.3)], INK, 1.2, "2 3", arrow=True)
    drawing.text(*place(pi / 2 - 0.3, pi / 2 + 0.6), "Ψ", BLUE, "end")
    drawing.text(*place(2 * pi + 0.9, 0.3), "Ψᶜ", ORANGE)
    for k, name in ((1, "π"), (3, "3π")):
        drawing.text(*place(k * pi + 0.2, -0.8 if k > 1 else 0.35), name, INK, size=13)
    drawing.text(*place(pi + 0.2, -pi - 0.9), "change of chart", INK, size=13)
    drawing.write("charts.svg")


frames()
charts()
