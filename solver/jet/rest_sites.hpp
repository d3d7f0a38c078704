#pragma once
// What the body at rest says about every place of its surface under a pad, from one factor of the body without a
// contact, A_0 = d2W/du2 at u = 0. With C the compliance of the surface's free nodes (their part of A_0^{-1}), M, m and
// t the pad's springs at the site s (moving_pad.hpp):
//   w = (I + M C)^{-1} m,   U = C w at the pad's nodes,   K(s) = t I - m^T U            [N/m]
//   dK/ds = t' I - m'^T U - U^T m' + U^T M' U                  (' by s; the rest of E is stationary)
//   A^{-1} b = A_0^{-1} (b - P (I + M C)^{-1} M P^T A_0^{-1} b),   A = A_0 + P M P^T    (Woodbury 1950)
// so a site costs a dense system of its pad's nodes, and its jet at rest three solves in lanes and no factor.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "solver/body/fine_jet.hpp"
#include "solver/jet/moving_pad.hpp"

namespace forefeel {

struct SiteRest {
  Mat3 stiffness = Mat3::Zero();  // K(s), of the body and the pad [N/m]
  std::array<Mat3, 3> stiffness_by{Mat3::Zero(), Mat3::Zero(),
                                   Mat3::Zero()};  // by the coordinates of s [N/m^2]; zero unless asked for
  Vec3 normal = Vec3::Zero();                      // mean normal under the pad
  Mat3 normal_by = Mat3::Zero();                   // column k: by s_k
  double springs = 0;                              // t
  double clamped_share = 0;
  // Of the body alone under the pad, (K^-1 - I / t)^-1 [N/m]
  Mat3 body_stiffness() const;
};

// Where a long computation keeps what it has, piece by piece, so that another run resumes. A piece is a list of
// numbers, always of one length. Called by one thread at a time.
class KeptPieces {
 public:
  virtual ~KeptPieces() = default;
  virtual bool take(std::uint64_t piece, std::span<double> values) = 0;  // false: it is not there
  virtual void keep(std::uint64_t piece, std::span<const double> values) = 0;
};

// Immutable after construction; any thread may ask.
class RestSites {
 public:
  // body.pad gives radius and stiffness; its site and the fine body do not count. The compliance is computed here, by
  // up to `threads` threads, unless it is given: compliance() of the same body. One of another length is computed anew.
  // progress: 0 to 1, first with what `kept` has. InputError without a pad, and if the body is not stable at rest.
  RestSites(std::shared_ptr<const Body> body, int threads, std::span<const double> compliance = {},
            const std::function<void(double)>& progress = {}, KeptPieces* kept = nullptr);
  ~RestSites();

  const Body& body() const;
  const SurfaceMap& map() const;
  const MovingPad& pad() const;
  SiteRest at(const SurfacePlace& site, bool slopes) const;
  std::vector<double> compliance() const;  // in one list, to be kept

 private:
  friend class SiteJets;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Makes jets at rest, of order 4; one object per thread.
class SiteJets {
 public:
  explicit SiteJets(const RestSites& sites);  // which must outlive this
  ~SiteJets();
  SiteJets(SiteJets&&) noexcept;
  RestJet at(const SurfacePlace& site);
  // du/dx at rest under the pad at a site: of each node of the mesh 3 x 3, row by row [1].
  std::vector<double> tangent(const SurfacePlace& site);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace forefeel
