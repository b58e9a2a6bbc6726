"""Derive the rational of detmath.h: a(w) = w A(w^2), b(w) = B(w^2) such that 2 t / (1 + t^2), t = a / b, is the minimax
of tanh(w) in relative error on 0 < w <= end. Pure Python, 50 decimal digits, seconds: python3 gen/tanh_fit.py

For an error eps of tanh the admissible t lie in a band c +- h that widens with w (it is symmetric under t -> 1/t, so
past saturation it reaches beyond 1). Rational Remez exchange on (t - c) / h finds the levelled error E; eps is changed
until E = 1. Printed: B monic, as hex floats with their decimals.
"""
import math
import struct
from decimal import Decimal as D, getcontext

getcontext().prec = 50


def tanh(w):
    e = (-2 * w).exp()
    return (1 - e) / (1 + e)


def half(y):
    """t with 2 t / (1 + t^2) = y."""
    return y / (1 + (1 - y * y).sqrt())


def band(w, eps):
    low = half(tanh(w) * (1 - eps))
    top = tanh(w) * (1 + eps)
    high = half(top) if top < 1 else 1 / low
    return (low + high) / 2, (high - low) / 2


def solve(rows):
    """Gauss elimination of rows [A | b]."""
    n = len(rows)
    for i in range(n):
        p = max(range(i, n), key=lambda r: abs(rows[r][i]))
        rows[i], rows[p] = rows[p], rows[i]
        for r in range(i + 1, n):
            f = rows[r][i] / rows[i][i]
            rows[r] = [x - f * y for x, y in zip(rows[r], rows[i])]
    x = [D(0)] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - sum(rows[i][j] * x[j] for j in range(i + 1, n))) / rows[i][i]
    return x


def poly(c, u):
    r = D(0)
    for v in reversed(c):
        r = r * u + v
    return r


def extrema(err, count):
    """Indices of alternating extrema, the smallest dropped down to count."""
    ext = [0]
    for i, e in enumerate(err):
        if (e > 0) != (err[ext[-1]] > 0):
            ext.append(i)
        elif abs(e) > abs(err[ext[-1]]):
            ext[-1] = i
    while len(ext) > count:
        if len(ext) == count + 1:
            ext.pop(0 if abs(err[ext[0]]) < abs(err[ext[-1]]) else -1)
        else:
            j = min(range(len(ext) - 1), key=lambda k: max(abs(err[ext[k]]), abs(err[ext[k + 1]])))
            del ext[j:j + 2]
    assert len(ext) == count, "too few extrema"
    return ext


def exchange(ws, bands, m, n, x):
    """Remez: x = [A0..Am, B1..Bn, E] with B0 = 1, ws scaled to 0..1."""
    for _ in range(60):
        A, B = x[:m + 1], [D(1)] + x[m + 1:-1]
        err = [(w * poly(A, w * w) / poly(B, w * w) - c) / h for w, (c, h) in zip(ws, bands)]
        ext = extrema(err, m + n + 2)
        size = [abs(err[i]) for i in ext]
        if max(size) < min(size) * D("1.001"):
            break
        if x[-1] == 0:
            x[-1] = (max(size) * min(size)).sqrt()
        for _ in range(30):                                     # Newton on the levelled equations
            A, B, rows = x[:m + 1], [D(1)] + x[m + 1:-1], []
            for i in ext:
                w, u, (c, h), s = ws[i], ws[i] ** 2, bands[i], 1 if err[i] > 0 else -1
                aim = c + s * x[-1] * h
                rows.append([w * u ** j for j in range(m + 1)] + [-aim * u ** j for j in range(1, n + 1)]
                            + [-s * h * poly(B, u), aim * poly(B, u) - w * poly(A, u)])
            step = solve(rows)
            x = [a + b for a, b in zip(x, step)]
            if max(map(abs, step)) < D("1e-30") * max(map(abs, x)):
                break
    return x


def fit(m, n, end, eps):
    end, eps, N, K = D(end), D(eps), 500, m + n + 1
    grid = sorted({D(1 - math.cos(math.pi * (i + 1) / N)) / 2 * end for i in range(N)}
                  | {end * (i + 1) / N for i in range(N)} | {end * (i + 1) ** 2 / N ** 2 for i in range(N)})
    ws, x = [w / end for w in grid], None
    while True:
        bands = [band(w, eps) for w in grid]
        if x is None:                                           # interpolate
            rows = []
            for i in range(K):
                k = min(range(len(ws)), key=lambda j: abs(float(ws[j]) - 0.5 * (1 - math.cos(math.pi * (i + 0.5) / K))))
                w, u, c = ws[k], ws[k] ** 2, bands[k][0]
                rows.append([w * u ** j for j in range(m + 1)] + [-c * u ** j for j in range(1, n + 1)] + [c])
            x = solve(rows) + [D(0)]
        x = exchange(ws, bands, m, n, x)
        if abs(abs(x[-1]) - 1) < D("0.003"):
            break
        eps *= abs(x[-1])
    lead = x[-2] / end ** (2 * n)
    A = [c / end ** (2 * j + 1) / lead for j, c in enumerate(x[:m + 1])]
    B = [c / end ** (2 * j) / lead for j, c in enumerate([D(1)] + x[m + 1:-1])]
    return eps, A, B


def main():
    for name, degree, end, eps in (("float", 2, "8.25", "1.7e-7"), ("double", 4, "14.5", "5.7e-13")):
        eps, A, B = fit(degree, degree, end, eps)
        print(f"{name}: |w| <= {end}, relative error {float(eps):.3e}")
        for letter, poly_ in (("A", A), ("B", B)):
            for j, c in enumerate(poly_):
                v = struct.unpack("f", struct.pack("f", float(c)))[0] if name == "float" else float(c)
                print(f"  {letter}{j} {v.hex()}  {v!r}")


if __name__ == "__main__":
    main()
