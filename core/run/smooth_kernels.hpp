// The arithmetic of the smoother of several modes, unrolled for each size of state.
#pragma once

#include "run/smooth_pairs.hpp"
#include "run/smooth_passages.hpp"

namespace jink::inline JINK_LEVEL {

// Of states of N components whose noise couples B at a time.
template <class T, int N, int B> SmoothKernels<T> smooth_kernels_of() {
    constexpr int K = Order<N, B>::shared;
    return {smooth_factor<T, N, B>,
            smooth_root<T, N>,
            smooth_blur<T, N, B>,
            smooth_spread<T, N>,
            smooth_thin<T, N>,
            {smooth_gram<T, N, B, K>, smooth_gram<T, N, B, N>},
            smooth_pull<T, N>,
            smooth_enter<T, N, B>,
            smooth_listen<T, N>,
            {smooth_hear<T, N, B, K>, smooth_hear<T, N, B, N>},
            {smooth_fuse<T, N, B, K>, smooth_fuse<T, N, B, N>},
            smooth_level<T, N, B>,
            smooth_merge<T, N, B>,
            smooth_unsound<T, N>};
}

}  // namespace jink::inline JINK_LEVEL
