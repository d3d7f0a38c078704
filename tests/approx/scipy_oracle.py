"""Forces by scipy.interpolate.RBFInterpolator, degree 1: STATES.csv POINTS.csv KERNEL N (0: all) OUT.csv"""
import sys

import numpy
from scipy.interpolate import RBFInterpolator

states = numpy.loadtxt(sys.argv[1], delimiter=",", ndmin=2)
points = numpy.loadtxt(sys.argv[2], delimiter=",", ndmin=2)
neighbours = int(sys.argv[4]) or None
field = RBFInterpolator(states[:, :3], states[:, 3:6], neighbors=neighbours, kernel=sys.argv[3], degree=1)
numpy.savetxt(sys.argv[5], field(points), delimiter=",", fmt="%.17g")
