#include "instances/update_kernels.hpp"

namespace jink::inline JINK_LEVEL {
template UpdateKernels<Pack> update_kernels<Pack>(const StateShape &);
}
