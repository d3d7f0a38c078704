"""Trains the recurrent net of the predictor `network:FILE` on synthetic hands (numpy alone).

    python3 train_network.py FILE.csv [STEPS]

A hand reaches from place to place with minimum jerk, pauses, circles and trembles. The net (scheduling/motion/
recurrent_net.hpp) sees the velocity of an axis and the speed over 20 ms; it gives, for each horizon, the way beyond a
constant velocity and the logarithm of its deviation. Both minimise the negative log-likelihood of the true way.
"""

import sys

import numpy as np

STEP, FINE, UNIT, HORIZONS, SIZE = 0.02, 5, 0.1, [0.04, 0.1, 0.2, 0.4, 0.8, 1.6], 16  # FINE: samples a step
AHEAD = [round(h / STEP) for h in HORIZONS]
LENGTH, BATCH, WARM = 150, 96, 10
rng = np.random.default_rng(1)


def hand(count):
    """Positions of one hand in count steps, [m], a row per sample."""
    count, dt = FINE * count, STEP / FINE
    t, way, at = np.arange(count) * dt, np.zeros((count, 3)), np.zeros(3)
    if rng.random() < 0.6:  # reaches and pauses
        k = 0
        while k < count:
            last = int(rng.uniform(0.25, 1.2) / dt)
            u = np.minimum(np.arange(1, last + 1 + int(rng.exponential(0.15) / dt)) / last, 1)
            goal = rng.uniform(-0.04, 0.04, 3)
            moved = at + (10 * u**3 - 15 * u**4 + 6 * u**5)[:, None] * (goal - at)
            way[k : k + len(u)] = moved[: count - k]
            at, k = goal, k + len(u)
    else:  # circles and curves of Lissajous
        turn = 2 * np.pi * rng.uniform(0.15, 1.5) * rng.choice([1, 1, 2, 3], 3)
        way = rng.uniform(0.003, 0.04, 3) * np.sin(turn * t[:, None] + rng.uniform(0, 6.3, 3))
    tremor = rng.choice([0, 1e-4, 2e-4, 3e-4]) * np.sqrt(2 / 3)
    for _ in range(3):
        way = way + tremor * np.sin(2 * np.pi * rng.uniform(8, 12, 3) * t[:, None] + rng.uniform(0, 6.3, 3))
    return way


def batch():
    """Inputs T x (3 BATCH) x 2, and the true ways beyond v s, T x (3 BATCH) x horizons, in units."""
    xs = np.stack([hand(LENGTH + 2 + max(AHEAD)) for _ in range(BATCH)], 1)
    v = np.diff(xs[::FINE], axis=0)[:LENGTH] / STEP
    xs = xs[rng.integers(FINE) :][::FINE]  # the newest sample comes after the newest step
    speed = np.repeat(np.linalg.norm(v, axis=2, keepdims=True), 3, 2)
    inputs = np.stack([v, speed], 3).reshape(LENGTH, -1, 2) / UNIT
    now = xs[1 : LENGTH + 1]
    ways = [(xs[1 + n : 1 + n + LENGTH] - now) / (n * STEP) - v for n in AHEAD]
    return inputs, np.stack(ways, 3).reshape(LENGTH, -1, len(AHEAD)) / UNIT


def logistic(x):
    return 1 / (1 + np.exp(-x))


def forward(w, inputs):
    s, kept = np.zeros((inputs.shape[1], SIZE)), []
    for u in inputs:
        z = logistic(u @ w["Wz"].T + s @ w["Uz"].T + w["bz"])
        r = logistic(u @ w["Wr"].T + s @ w["Ur"].T + w["br"])
        n = np.tanh(u @ w["Wn"].T + (r * s) @ w["Un"].T + w["bn"])
        kept.append((u, s, z, r, n))
        s = s + z * (n - s)
    states = np.stack([s0 + z * (n - s0) for _, s0, z, _, n in kept])
    return states, states @ w["V"].T + w["c"], kept


def loss_and_gradient(w, inputs, truth):
    states, y, kept = forward(w, inputs)
    k = len(AHEAD)
    logs = np.clip(y[..., k:], -7, 3)
    error, g = (y[..., :k] - truth) * np.exp(-logs), {name: np.zeros_like(a) for name, a in w.items()}
    scale = 1 / (y.shape[1] * k * (LENGTH - WARM))
    dy = scale * np.concatenate([error * np.exp(-logs), 1 - error**2], 2)
    dy[:WARM] = 0
    g["V"], g["c"] = np.einsum("tbo,tbs->os", dy, states), dy.sum((0, 1))
    ds = np.zeros_like(states[0])
    for t in range(LENGTH - 1, -1, -1):
        u, s, z, r, n = kept[t]
        ds = ds + dy[t] @ w["V"]
        dn, dz = ds * z * (1 - n**2), ds * (n - s) * z * (1 - z)
        drs = dn @ w["Un"]
        dr = drs * s * r * (1 - r)
        for name, d, seen in (("z", dz, s), ("r", dr, s), ("n", dn, r * s)):
            g["W" + name] += d.T @ u
            g["U" + name] += d.T @ seen
            g["b" + name] += d.sum(0)
        ds = ds * (1 - z) + drs * r + dz @ w["Uz"] + dr @ w["Ur"]
    return scale * (0.5 * error**2 + logs)[WARM:].sum(), g


def train(steps):
    w = {}
    for gate in "zrn":
        w["W" + gate], w["U" + gate] = rng.normal(0, 0.5, (SIZE, 2)), rng.normal(0, SIZE**-0.5, (SIZE, SIZE))
        w["b" + gate] = np.zeros(SIZE)
    w["V"], w["c"] = rng.normal(0, 0.1, (2 * len(AHEAD), SIZE)), np.zeros(2 * len(AHEAD))
    m, q = ({name: np.zeros_like(a) for name, a in w.items()} for _ in range(2))
    for i in range(1, steps + 1):  # Adam
        loss, g = loss_and_gradient(w, *batch())
        shrink = min(1, 1 / np.sqrt(sum((a**2).sum() for a in g.values())))
        for name in w:
            m[name] = 0.9 * m[name] + 0.1 * shrink * g[name]
            q[name] = 0.999 * q[name] + 0.001 * (shrink * g[name]) ** 2
            rate = 0.01 * min(1, 2 * (1 - i / (steps + 1)))
            w[name] -= rate * (m[name] / (1 - 0.9**i)) / (np.sqrt(q[name] / (1 - 0.999**i)) + 1e-9)
        if i % 100 == 0:
            print(f"step {i}: negative log-likelihood {loss:.3f}", flush=True)
    return w


if __name__ == "__main__":
    weights = train(int(sys.argv[2]) if len(sys.argv) > 2 else 1500)
    with open(sys.argv[1], "w") as file:
        for name, values in {"step": STEP, "unit": UNIT, "horizons": HORIZONS, **weights}.items():
            print(name, *(repr(float(x)) for x in np.ravel(values)), sep=",", file=file)
