#include "instances/motion_kernels.hpp"

namespace jink::inline JINK_LEVEL {
template MotionKernels<Pack> motion_kernels<Pack>(const MotionSpec &, bool);
}
