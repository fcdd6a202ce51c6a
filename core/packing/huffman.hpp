// Text as a deflate stream of Huffman codes alone, without a search for what repeats: one block, read by every gzip reader.
//
// Digits of measured numbers hardly repeat, so a search finds little. Codes have 12 bits at most: four of them and the bits that
// wait fit a word of 64, and two are looked up at a time. RFC 1951, sections 3.2.2 and 3.2.7.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace jink::packing {

static_assert(std::endian::native == std::endian::little, "words of bits are stored as they lie in memory");

inline constexpr int symbols = 257, end_of_block = 256, longest = 12;
inline constexpr std::size_t spare = 8;  // bytes after the stream that may be written to

class Huffman {
  public:
    explicit Huffman(const unsigned char *text, std::size_t size) : text(text), size(size) {
        count();
        set_lengths();
        set_codes();
    }

    // Of the whole stream, in bytes.
    std::size_t bytes() const {
        std::size_t bits = header_bits;
        for (int s = 0; s < symbols; ++s) bits += frequency[s] * length[s];
        return (bits + 7) / 8;
    }

    // Writes bytes() of them, and may touch `spare` more.
    void write(unsigned char *out) {
        at = out, bits = 0, waiting = 0;
        write_header();
        std::size_t k = write_pairs();
        for (; k < size; ++k) put(code[text[k]], length[text[k]]);
        put(code[end_of_block], length[end_of_block]);
        put(0, 7);  // what waits is less than a byte
    }

  private:
    // last block, dynamic codes, their numbers; lengths of the codes of lengths; lengths of 257 literals and 2 distances
    static constexpr std::size_t header_bits = 3 + 5 + 5 + 4 + 19 * 3 + (symbols + 2) * 4;

    const unsigned char *text;
    std::size_t size;
    std::array<std::uint64_t, symbols> frequency{};
    std::array<std::uint8_t, symbols> length{};
    std::array<std::uint16_t, symbols> code{};
    unsigned char *at = nullptr;
    std::uint64_t bits = 0;
    int waiting = 0;

    void count() {
        std::array<std::array<std::uint32_t, 256>, 4> lanes{};  // a count that follows itself waits for its store
        std::size_t k = 0;
        for (; k + 8 <= size; k += 8) {
            std::uint64_t eight;
            std::memcpy(&eight, text + k, 8);
            for (int l = 0; l < 8; ++l) ++lanes[l & 3][eight >> (8 * l) & 0xff];
        }
        for (; k < size; ++k) ++lanes[0][text[k]];
        for (int s = 0; s < 256; ++s)
            for (const auto &lane : lanes) frequency[s] += lane[s];
        frequency[end_of_block] = 1;
    }

    // Depths in Huffman's tree; while it is too deep, of frequencies that differ less. A text of one symbol has a tree of two.
    void set_lengths() {
        std::array<std::uint64_t, symbols> weight = frequency;
        if (size == 0) weight[0] = 1;
        while (true) {
            std::vector<int> order;
            for (int s = 0; s < symbols; ++s)
                if (weight[s]) order.push_back(s);
            std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return weight[a] < weight[b]; });
            if (grow(order, weight) <= longest) return;
            for (auto &w : weight) w = w ? (w >> 1) | 1 : 0;
        }
    }

    // Leaves in ascending order, then the nodes that join two of the lightest, which come in ascending order too.
    int grow(const std::vector<int> &order, const std::array<std::uint64_t, symbols> &weight) {
        const int leaves = int(order.size());
        std::vector<std::uint64_t> sum(2 * leaves - 1);
        std::vector<int> parent(2 * leaves - 1), depth(2 * leaves - 1, 0);
        for (int k = 0; k < leaves; ++k) sum[k] = weight[order[k]];
        int leaf = 0, joined = leaves;
        for (int next = leaves; next < 2 * leaves - 1; ++next)
            for (int child = 0; child < 2; ++child) {
                const bool from_leaves = leaf < leaves && (joined >= next || sum[leaf] <= sum[joined]);
                const int taken = from_leaves ? leaf++ : joined++;
                sum[next] += sum[taken], parent[taken] = next;
            }
        int deepest = 0;
        for (int k = 2 * leaves - 3; k >= 0; --k) {
            depth[k] = depth[parent[k]] + 1;
            deepest = std::max(deepest, depth[k]);
            if (k < leaves) length[order[k]] = std::uint8_t(std::min(depth[k], 255));
        }
        return deepest;
    }

    // Codes of one length follow one another; they are sent with the first bit lowest.
    void set_codes() {
        std::array<int, longest + 2> of_length{}, next{};
        for (const auto l : length) of_length[l] += l > 0;
        for (int l = 1; l <= longest; ++l) next[l] = (next[l - 1] + of_length[l - 1]) << 1;
        for (int s = 0; s < symbols; ++s)
            if (length[s]) code[s] = std::uint16_t(reversed(next[length[s]]++, length[s]));
    }

    static unsigned reversed(unsigned value, int count) {
        unsigned out = 0;
        for (int k = 0; k < count; ++k) out |= (value >> k & 1u) << (count - 1 - k);
        return out;
    }

    // Both codes of two bytes in a row, and above them how many bits they have.
    std::vector<std::uint32_t> codes_of_pairs() const {
        std::vector<std::uint32_t> pairs(1 << 16);
        for (int second = 0; second < 256; ++second)
            for (int first = 0; length[second] && first < 256; ++first)
                if (length[first])
                    pairs[first | second << 8] = code[first] | std::uint32_t(code[second]) << length[first] | std::uint32_t(length[first] + length[second]) << 24;
        return pairs;
    }

    // Lengths of codes are sent as such: each of the sixteen that there may be has a code of four bits.
    void write_header() {
        put(1, 1), put(2, 2), put(symbols - 257, 5), put(1, 5), put(15, 4);
        for (int k = 0; k < 19; ++k) put(k < 3 ? 0 : 4, 3);  // the first three would repeat
        for (const auto l : length) put(reversed(l, 4), 4);
        for (int k = 0; k < 2; ++k) put(reversed(1, 4), 4);  // two distances that never come: some readers want a whole code
    }

    // As many bytes as there are fours. Numbers of its own: what is stored might else be them.
    std::size_t write_pairs() {
        const std::vector<std::uint32_t> made = codes_of_pairs();
        const std::uint32_t *pairs = made.data();
        const unsigned char *from = text, *end = text + size / 4 * 4;
        unsigned char *to = at;
        std::uint64_t word = bits;
        unsigned held = unsigned(waiting);
        for (; from < end; from += 4) {
            std::uint32_t four;
            std::memcpy(&four, from, 4);
            const std::uint32_t low = pairs[four & 0xffff], high = pairs[four >> 16];
            const std::uint64_t both = std::uint64_t(low & 0xffffff) | std::uint64_t(high & 0xffffff) << (low >> 24);
            word |= both << held, held += (low >> 24) + (high >> 24);
            std::memcpy(to, &word, 8);
            to += held >> 3, word >>= held & ~7u, held &= 7;
        }
        at = to, bits = word, waiting = int(held);
        return size / 4 * 4;
    }

    void put(std::uint64_t value, int count) {
        bits |= value << waiting, waiting += count;
        flush();
    }

    void flush() {
        std::memcpy(at, &bits, 8);
        at += waiting >> 3, bits >>= waiting & ~7, waiting &= 7;
    }
};

}  // namespace jink::packing
