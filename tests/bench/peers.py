"""numpy and scipy as peers of the benchmark: the same equations, timed on request.

stdin   the nominal problem and the reference trajectory as the benchmark has them (bench.h), then one name a line
stdout  the names, an empty line, then for each name asked for: ns of a simulated millisecond and realisation, error [rpm]
"""
import sys
import time

import numpy as np
from scipy.integrate import solve_ivp

MODES, SECONDS, STEPS, FINE = 10, 100.0, 100000, 8
RPM = 0.10471975511965977
MANY = 400                       # realisations of numpy
MANY_SECONDS = 3.0               # its time a step does not change, so a short stretch is fair


def read(count):
    return np.frombuffer(sys.stdin.buffer.read(8 * count))


values = read(5 * MODES + 6)
w2, c, b, d, drag = values[:5 * MODES].reshape(5, MODES)
fc, f0, mu, a1, a2, w0 = values[5 * MODES:]
reference = read(STEPS * FINE + 1)


def error_of(t, w):
    """Largest distance from the reference [rpm]: the cubic through its four nearest points."""
    x = t * (1e3 * FINE)
    n = np.clip(x.astype(int), 1, STEPS * FINE - 2)
    s = x - n
    between = (-s * (s - 1) * (s - 2) / 6 * reference[n - 1] + (s + 1) * (s - 1) * (s - 2) / 2 * reference[n]
               - (s + 1) * s * (s - 2) / 2 * reference[n + 1] + (s + 1) * s * (s - 1) / 6 * reference[n + 2])
    return np.abs(w - between).max() / RPM


def scipy_peer(method, rtol, atol, longest):
    from math import sin, tanh
    matrix = np.zeros((2 * MODES, 2 * MODES))            # linear part, one product a call
    matrix[:MODES, MODES:] = np.eye(MODES)
    matrix[MODES:, :MODES] = -np.diag(w2)
    matrix[MODES:, MODES:] = -np.diag(c)
    drive = np.concatenate((np.zeros(MODES), b))
    constant = np.concatenate((np.zeros(MODES), -drag))
    scalars = tuple(float(x) for x in (fc, f0, mu, a1, a2, w0))

    def derive(t, y, fc, f0, mu, a1, a2, w0):
        w = w0 + float(b.dot(y[MODES:]))
        f = min(f0 * (sin(w0 * t) + 0.01) - fc, 0.0)
        return matrix.dot(y) + (mu * f * (tanh(w) + a1 * w / (1 + a2 * w * w))) * drive + constant

    def run():
        begin = time.process_time()
        out = solve_ivp(derive, (0.0, SECONDS), np.concatenate((np.zeros(MODES), -d * w0)), method=method, rtol=rtol, atol=atol,
                        max_step=longest, args=scalars)
        took = time.process_time() - begin
        return 1e9 * took / STEPS, error_of(out.t, w0 + b @ out.y[MODES:]) if out.status == 0 else float("nan")
    return run


def numpy_rk4():
    """RK4 at 1 ms over MANY realisations at once, (mode, realisation) arrays, no temporary allocated in the loop."""
    h = 1e-3
    fc, f0, mu, a1, a2, w0 = (np.full(MANY, x) for x in values[5 * MODES:])     # random for everybody else
    column = [np.repeat(x[:, None], MANY, 1) for x in (w2, c, b, drag)]
    q = np.zeros((MODES, MANY))
    v = np.repeat((-d * values[-1])[:, None], MANY, 1)
    k_q, k_v = np.empty((4, MODES, MANY)), np.empty((4, MODES, MANY))
    at_q, at_v, work = np.empty_like(q), np.empty_like(q), np.empty_like(q)
    steps = int(MANY_SECONDS / h)
    speed = np.empty(steps + 1)
    lowest, highest = np.full(MANY, np.inf), np.full(MANY, -np.inf)

    def bit_speed(v):
        return w0 + np.einsum("ij,ij->j", column[2], v)

    def derive(t, w, q, v, dq, dv):
        f = np.minimum(f0 * (np.sin(w0 * t) + 0.01) - fc, 0.0)
        torque = mu * f * (np.tanh(w) + a1 * w / (1 + a2 * w * w))
        dq[...] = v
        np.multiply(column[2], torque, out=dv)
        np.subtract(dv, column[3], out=dv)
        np.subtract(dv, np.multiply(column[1], v, out=work), out=dv)
        np.subtract(dv, np.multiply(column[0], q, out=work), out=dv)

    def along(part, dq, dv):
        np.add(q, np.multiply(dq, part, out=at_q), out=at_q)
        np.add(v, np.multiply(dv, part, out=at_v), out=at_v)

    begin = time.process_time()
    w = bit_speed(v)
    speed[0] = w[0]
    for n in range(steps):
        t = n * h
        derive(t, w, q, v, k_q[0], k_v[0])
        for stage, part in ((1, h / 2), (2, h / 2), (3, h)):
            along(part, k_q[stage - 1], k_v[stage - 1])
            derive(t + part, bit_speed(at_v), at_q, at_v, k_q[stage], k_v[stage])
        for x, k in ((q, k_q), (v, k_v)):
            np.add(k[1], k[2], out=k[1])
            np.multiply(k[1], 2.0, out=k[1])
            np.add(k[1], k[0], out=k[1])
            np.add(k[1], k[3], out=k[1])
            np.multiply(k[1], h / 6, out=k[1])
            np.add(x, k[1], out=x)
        w = bit_speed(v)
        np.minimum(lowest, w, out=lowest)
        np.maximum(highest, w, out=highest)
        speed[n + 1] = w[0]
    took = time.process_time() - begin
    return 1e9 * took / (steps * MANY), error_of(np.arange(steps + 1) * h, speed)


# name: setting, run; the settings come from --scan
PEERS = {
    f"numpy RK4, {MANY} realisations": ("1 ms", numpy_rk4),
    "scipy solve_ivp RK45": ("rtol 1e-5, atol 1e-4, h <= 4.2 ms", scipy_peer("RK45", 1e-5, 1e-4, 4.2e-3)),
    "scipy solve_ivp LSODA": ("rtol 3e-8, atol 3e-6, h <= 3 ms", scipy_peer("LSODA", 3e-8, 3e-6, 3e-3)),
}


def main():
    if len(sys.argv) > 1 and sys.argv[1] == "--scan":
        for method in ("RK45", "LSODA"):
            for longest in (np.inf, 4e-3, 3e-3):
                for ratio in (1.0, 10.0, 100.0):
                    for rtol in (1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8):
                        ns, error = scipy_peer(method, rtol, ratio * rtol, longest)()
                        print(f"{method:6} h <= {longest:g} rtol {rtol:.0e} atol {ratio * rtol:.0e} {error:9.4f} rpm {ns:8.0f} ns", flush=True)
        return
    print("".join(f"{name}\t{setting}\n" for name, (setting, _) in PEERS.items()), flush=True)
    for line in sys.stdin.buffer:
        print("%.3f %.6g" % PEERS[line.decode().strip()][1](), flush=True)


if __name__ == "__main__":
    main()
