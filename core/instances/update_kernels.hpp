// Which kernels belong to which shape of state; included by the one translation unit per number type that instantiates them.
#pragma once

#include "scan/update.hpp"

namespace jink::inline JINK_LEVEL {

template <class T, int A, int B, int N> UpdateKernels<T> update_kernels_of() {
    return {update_direct<T, A, B, N, false>, update_direct<T, A, B, N, true>, update_general<T, B, N>, update_unscented<T, B, N>};
}

template <class T, int A> UpdateKernels<T> update_kernels_for_axes(const StateShape &shape) {
    if (shape.block == 3) return update_kernels_of<T, A, 3, 3 * A>();
    if constexpr (A >= 2)
        if (shape.turn) return update_kernels_of<T, A, 2, 2 * A + 1>();
    return update_kernels_of<T, A, 2, 2 * A>();
}

template <class T> UpdateKernels<T> update_kernels(const StateShape &shape) {
    if (shape.axes == 1) return update_kernels_for_axes<T, 1>(shape);
    if (shape.axes == 2) return update_kernels_for_axes<T, 2>(shape);
    return update_kernels_for_axes<T, 3>(shape);
}

}  // namespace jink::inline JINK_LEVEL
