// Wide: one number of W neighbours in memory, one per lane. Vectors and matrices of them, Vec3T<Wide<4>>, are how
// blocks of bodies and joints lie in memory (kernel/plan/blocks.h); simd/wide_packs.h loads and stores them as packs.
#pragma once

namespace unlatch {

template <int W>
struct Wide {
  double lane[W];
};

}  // namespace unlatch
