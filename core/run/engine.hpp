// A filter ready to run: the same declaration for packs (batches) and for one number (one live target).
#pragma once

#include <memory>

#include "scan/composition.hpp"

namespace jink::inline JINK_LEVEL {

struct Engine {
    std::shared_ptr<const Composition<Pack>> pack;
    std::shared_ptr<const Composition<double>> scalar;
};

}  // namespace jink::inline JINK_LEVEL
