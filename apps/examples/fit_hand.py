"""A synthetic hand like recorded ones: fit_hand.py TRACE.csv … (t,x,y,z in s and m, as `forefeel trace -o` writes).

Prints the device of each recording and of all: speed while moving, amplitude, tremor (RMS of an axis from 8 to 12 Hz)
and noise (RMS of an axis, white, from what lies above 15 Hz). A recording below 30 Hz shows no tremor, below 60 Hz no
noise. Each pause is at a turn of the path.
"""
import sys

import numpy as np

REST = 0.005  # below this speed a hand rests [m/s]


def fit(file):
    t, *xyz = np.loadtxt(file, delimiter=",", skiprows=1).T
    step = float(np.median(np.diff(t)))
    even = np.arange(t[0], t[-1], step)
    x = np.stack([np.interp(even, t, axis) for axis in xyz], 1)
    # Moving or at rest: speed over 0.1 s, so that tremor does not count as a motion.
    lag = max(1, round(0.1 / step))
    speed = np.linalg.norm(x[lag:] - x[:-lag], axis=1) / (lag * step)
    resting = np.r_[False, speed < REST, False]
    begin, end = np.flatnonzero(np.diff(resting.astype(int)) == 1), np.flatnonzero(np.diff(resting.astype(int)) == -1)
    pauses = (end - begin) * step
    # Power of an axis by frequency, from the spectrum of the second difference: slow motion does not leak into it.
    frequency = np.fft.rfftfreq(len(x) - 2, step)[1:]
    window = np.hanning(len(x) - 2)[:, None]
    curved = np.abs(np.fft.rfft(window * np.diff(x, 2, axis=0), axis=0)[1:]) ** 2
    gain = (2 * np.sin(np.pi * frequency * step)) ** 4
    power = 2 * (curved / gain[:, None]).mean(1) / (len(window) * (window**2).sum())
    share = lambda low, high: power[(frequency >= low) & (frequency <= high)].sum()
    top, nyquist = 15.0, 0.5 / step
    noise2 = share(top, nyquist) * nyquist / (nyquist - top) if nyquist >= 2 * top else 0.0
    tremor2 = share(8, 12) - noise2 * 4 / nyquist if nyquist > 14 else 0.0
    return {"speed": np.median(speed[speed >= REST]) if (speed >= REST).any() else REST,
            "amplitude": np.linalg.norm(x - 0.5 * (x.max(0) + x.min(0)), axis=1).max(),
            "tremor": np.sqrt(max(tremor2, 0)), "noise": np.sqrt(noise2),
            "resting": resting.mean(), "pause": np.median(pauses) if len(pauses) else 0.0}


def device(of):
    return f"path:tour,speed={of['speed']:.3g},amplitude={of['amplitude']:.3g}" + "".join(
        f",{key}={of[key]:.2g}" for key in ("tremor", "noise", "pause") if of[key] > 0)


fits = [fit(file) for file in sys.argv[1:]]
for file, one in zip(sys.argv[1:], fits):
    print(f'"{device(one)}"  # {file}: rests {100 * one["resting"]:.0f} % of the time, {one["pause"]:.2g} s each')
print(f'"{device({key: np.median([one[key] for one in fits]) for key in fits[0]})}"  # all: medians')
