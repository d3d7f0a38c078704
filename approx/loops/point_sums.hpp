#pragma once
// The loops over points of kernel_sums.hpp: extent of a set, its planes, its mean tangent. Compiled once per
// instruction set.

#include <cstddef>

namespace forefeel::FOREFEEL_ISA {

void supports(std::size_t n, const double* px, const double* py, const double* pz, const double axes[13][3],
              double low[13], double high[13]);
void extent(std::size_t n, const double* px, const double* py, const double* pz, const double* weight,
            double out[5]);
void distances(std::size_t n, const double* px, const double* py, const double* pz, const double* weight,
               const double y[3], double* distance, double out[2]);
void tangent(std::size_t n, const double* px, const double* py, const double* pz, const double* weight,
             const double* data, std::size_t stride, const double* distance, double nearest, double farthest,
             const double base[3], double out[19]);

}  // namespace forefeel::FOREFEEL_ISA
