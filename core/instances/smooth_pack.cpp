#include "instances/instances.hpp"

namespace jink::inline JINK_LEVEL {
JINK_SMOOTH(, Pack)
}
