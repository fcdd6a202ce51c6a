// A live state as bytes: a header that says of which filter it is, then numbers, the same on every machine.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace jink::inline JINK_LEVEL {

static_assert(std::endian::native == std::endian::little, "saved states are little-endian");

// FNV-1a over bytes.
class Digest {
  public:
    template <class V> void number(V value) { bytes(&value, sizeof value); }
    template <class V> void numbers(const std::vector<V> &values) {
        number(std::uint64_t(values.size()));
        for (const V &value : values) number(value);
    }
    void bytes(const void *from, std::size_t count) {
        const auto *byte = static_cast<const unsigned char *>(from);
        for (std::size_t k = 0; k < count; ++k) value_ = (value_ ^ byte[k]) * 1099511628211ull;
    }
    std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 1469598103934665603ull;
};

struct SavedHeader {
    char magic[8];               // "jinklive"
    std::uint64_t version;
    std::uint64_t fingerprint;   // of the filter
    std::uint64_t targets, numbers;
    std::uint64_t checksum;      // of the numbers

    static constexpr std::uint64_t current = 4;
};

inline std::string saved_state(std::uint64_t fingerprint, int targets, int numbers, const std::vector<double> &all) {
    SavedHeader header{{'j', 'i', 'n', 'k', 'l', 'i', 'v', 'e'}, SavedHeader::current, fingerprint, std::uint64_t(targets), std::uint64_t(numbers), 0};
    Digest digest;
    digest.bytes(all.data(), all.size() * sizeof(double));
    header.checksum = digest.value();
    std::string text(sizeof header + all.size() * sizeof(double), '\0');
    std::memcpy(text.data(), &header, sizeof header);
    std::memcpy(text.data() + sizeof header, all.data(), all.size() * sizeof(double));
    return text;
}

// The numbers of a saved state. Throws std::invalid_argument where it is not one of this filter, whole and unchanged.
inline std::vector<double> state_numbers(const char *from, std::size_t size, std::uint64_t fingerprint, int targets, int numbers) {
    SavedHeader header;
    if (size < sizeof header) throw std::invalid_argument("state: expected what save() gave, got too few bytes");
    std::memcpy(&header, from, sizeof header);
    if (std::memcmp(header.magic, "jinklive", 8) != 0) throw std::invalid_argument("state: expected what save() gave, got other bytes");
    if (header.version != SavedHeader::current) throw std::invalid_argument("state: was saved by another version of jink");
    if (header.fingerprint != fingerprint) throw std::invalid_argument("state: was saved by another filter");
    if (header.targets != std::uint64_t(targets)) throw std::invalid_argument("state: was saved for another number of targets (" + std::to_string(header.targets) + ")");
    const std::size_t count = std::size_t(targets) * numbers;
    if (header.numbers != std::uint64_t(numbers) || size != sizeof header + count * sizeof(double)) throw std::invalid_argument("state: is not whole");
    std::vector<double> all(count);
    std::memcpy(all.data(), from + sizeof header, count * sizeof(double));
    Digest digest;
    digest.bytes(all.data(), count * sizeof(double));
    if (digest.value() != header.checksum) throw std::invalid_argument("state: its bytes were changed since it was saved");
    return all;
}

}  // namespace jink::inline JINK_LEVEL
