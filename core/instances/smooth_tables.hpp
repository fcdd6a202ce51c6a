// Which smoothing kernels belong to which shape of state; included by the one translation unit per number type that instantiates them.
#pragma once

#include "run/smooth_kernels.hpp"

namespace jink::inline JINK_LEVEL {

template <class T> SmoothKernels<T> smooth_kernels(const StateShape &shape, bool full) {
    switch (shape.n) {
        case 2: return smooth_kernels_of<T, 2, 2>();
        case 3: return smooth_kernels_of<T, 3, 3>();
        case 4: return smooth_kernels_of<T, 4, 2>();
        case 5: return full ? smooth_kernels_of<T, 5, 5>() : smooth_kernels_of<T, 5, 2>();
        case 6: return shape.block == 2 ? smooth_kernels_of<T, 6, 2>() : smooth_kernels_of<T, 6, 3>();
        case 7: return full ? smooth_kernels_of<T, 7, 7>() : smooth_kernels_of<T, 7, 2>();
        default: return smooth_kernels_of<T, 9, 3>();
    }
}

}  // namespace jink::inline JINK_LEVEL
