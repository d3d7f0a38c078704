"""The 95 % quantile of |error| of each kernel of scipy.interpolate.RBFInterpolator, one a line:
STATES.csv (x,y,z,fx,fy,fz) POINTS.csv (x,y,z and the true force) OUT.txt"""
import sys

import numpy
from scipy.interpolate import RBFInterpolator

states = numpy.loadtxt(sys.argv[1], delimiter=",", ndmin=2)
points = numpy.loadtxt(sys.argv[2], delimiter=",", ndmin=2)
with open(sys.argv[3], "w") as out:
    for kernel, epsilon in [("linear", 1), ("thin_plate_spline", 1), ("cubic", 1), ("quintic", 1),
                            ("gaussian", 100), ("multiquadric", 100), ("inverse_multiquadric", 100)]:
        for neighbours in (None, 50):
            try:
                field = RBFInterpolator(states[:, :3], states[:, 3:6], neighbors=neighbours, kernel=kernel,
                                        epsilon=epsilon)
                error = numpy.linalg.norm(field(points[:, :3]) - points[:, 3:6], axis=1)
            except numpy.linalg.LinAlgError:
                continue
            out.write(f"{numpy.quantile(error, 0.95):.17g}\n")
