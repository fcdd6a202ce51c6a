// Numbers as text: the shortest that reads back as the same number, bit for bit.
//
// Raffaello Giulietti, "The Schubfach way to render doubles" (2020): of the decimals that lie in the interval which rounds to x, one of the fewest
// digits, of these the closest to x.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace jink::inline JINK_LEVEL::text {

using Wide = unsigned __int128;

// 10^k = g 2^e for k in [-292, 324], rounded up to 128 bits of which the first is set.
struct TensTable {
    static constexpr int first = -292, last = 324;
    std::array<Wide, last - first + 1> g{};

    constexpr TensTable() {
        Number number{};
        number[5] = 1;  // above five words of zeros, so that there always are as many below the first
        for (int k = 0; k <= last; ++k) {
            std::uint64_t carry = 0;
            g[k - first] = top(number, false);
            for (auto &word : number) carry += 5ull * word, word = std::uint32_t(carry), carry >>= 32;
        }
        number = {};
        number[number.size() - 1] = 1;  // 2^1056, divided by 5^-k, of which 378 bits are left
        for (int k = -1; k >= first; --k) {
            std::uint64_t rest = 0;
            for (auto word = number.rbegin(); word != number.rend(); ++word) rest = rest << 32 | *word, *word = std::uint32_t(rest / 5), rest %= 5;
            g[k - first] = top(number, true);  // never exact
        }
    }

private:
    using Number = std::array<std::uint32_t, 34>;  // from the lowest word up

    // The first 128 bits of a number, rounded up where it has more.
    static constexpr Wide top(const Number &number, bool more) {
        std::size_t word = number.size() - 1;
        while (number[word] == 0) --word;
        const int shift = std::countl_zero(number[word]);
        Wide out = 0;
        for (int k = 0; k < 4; ++k) out = out << 32 | number[word--];
        const std::uint64_t next = std::uint64_t(number[word]) << shift;
        more |= std::uint32_t(next) != 0;
        while (word > 0) more |= number[--word] != 0;
        return (out << shift | next >> 32) + more;
    }
};

inline constexpr TensTable tens;

constexpr auto tens_whole = [] {
    std::array<std::uint64_t, 20> out{1};
    for (int k = 1; k < 20; ++k) out[k] = 10 * out[k - 1];
    return out;
}();

struct Decimal {  // digits 10^exponent
    std::uint64_t digits;
    int exponent;
};

// c g / 2^128, whose last bit also stands for all that is cut off.
inline std::uint64_t round_to_odd(Wide g, std::uint64_t c) {
    const Wide low = Wide(std::uint64_t(g)) * c, high = Wide(std::uint64_t(g >> 64)) * c + std::uint64_t(low >> 64);
    return std::uint64_t(high >> 64) | (std::uint64_t(high) > 1);
}

// The shortest decimal of a number that is finite and above 0. Real: float or double.
template <class Real> Decimal shortest(Real value) {
    using Bits = std::conditional_t<sizeof(Real) == 8, std::uint64_t, std::uint32_t>;
    constexpr int fraction = std::numeric_limits<Real>::digits - 1, bias = std::numeric_limits<Real>::max_exponent - 1 + fraction;
    const Bits bits = std::bit_cast<Bits>(value), significand = bits & ((Bits(1) << fraction) - 1);
    const int biased = int(bits >> fraction);
    const std::uint64_t c = biased ? significand | Bits(1) << fraction : significand;
    const int q = (biased ? biased : 1) - bias;
    if (q <= 0 && -q <= fraction && (c & ((1ull << -q) - 1)) == 0) return {c >> -q, 0};

    const bool odd = c & 1, uneven = significand == 0 && biased > 1;  // the number below is half as far as the one above
    const int k = uneven ? (q * 1262611 - 524031) >> 22 : (q * 1262611) >> 22;  // floor of log10 of the interval's width
    const int shift = q + ((-k * 1741647) >> 19) + 1;
    const Wide g = tens.g[-k - TensTable::first];
    const std::uint64_t from = round_to_odd(g, (4 * c - 2 + uneven) << shift) + odd, to = round_to_odd(g, (4 * c + 2) << shift) - odd;
    const std::uint64_t middle = round_to_odd(g, (4 * c) << shift), s = middle / 4;
    const std::uint64_t tenth = s / 10, half = 4 * s + 2;
    const bool tenth_below = from <= 40 * tenth, tenth_above = 40 * tenth + 40 <= to, below = from <= 4 * s, above = 4 * s + 4 <= to;
    // without branches, which nobody could predict
    const bool fewer = (tenth_below != tenth_above) & (s >= 10), up = below != above ? above : (middle > half) | ((middle == half) & (s & 1));
    const std::uint64_t mask = 0 - std::uint64_t(fewer);
    return {((tenth + tenth_above) & mask) | ((s + up) & ~mask), k + fewer};
}

// Sixteen digits of two numbers below 10^8, the first in the lowest byte.
struct Digits {
    std::uint64_t high, low;
};

inline Digits digits_of(std::uint64_t high, std::uint64_t low) {
    using Fours = std::uint32_t __attribute__((vector_size(16)));
    using Twos = std::uint16_t __attribute__((vector_size(16)));
    const auto halved = [](std::uint64_t n) { return (n << 32) - ((10000ull << 32) - 1) * ((n * 0x68db8bb) >> 40); };
    const Digits split{halved(high), halved(low)};
    const auto fours = std::bit_cast<Fours>(split);
    const auto twos = std::bit_cast<Twos>((fours << 16) - ((100u << 16) - 1) * ((fours * 0x147b) >> 19));
    return std::bit_cast<Digits>((twos << 8) - std::uint16_t((10 << 8) - 1) * ((twos * 0x67) >> 10));
}

constexpr std::uint64_t zeros = 0x3030303030303030;  // as text

inline void put_eight(char *to, std::uint64_t digits) {
    digits |= zeros;
    std::memcpy(to, &digits, 8);
}

// Up to 20 digits; the end of them. Writes up to 7 bytes more.
inline char *put_whole(char *to, std::uint64_t n) {
    if (n < 10) return *to = char('0' + n), to + 1;
    if (n >= tens_whole[8]) return to = put_whole(to, n / tens_whole[8]), put_eight(to, digits_of(n % tens_whole[8], 0).high), to + 8;
    const std::uint64_t digits = digits_of(n, 0).high;
    const int skipped = std::countr_zero(digits) / 8;
    put_eight(to, (digits | zeros) >> 8 * skipped);
    return to + 8 - skipped;
}

inline char *put_whole(char *to, std::int64_t n) {
    if (n < 0) *to++ = '-';
    return put_whole(to, n < 0 ? 0 - std::uint64_t(n) : std::uint64_t(n));
}

// A finite number, with a point or an exponent: 1.0, 0.00012, 1e-7, 1.5e+22. Writes up to 32 bytes.
template <class Real> char *put_real(char *to, Real value) {
    *to = '-', to += std::signbit(value), value = std::abs(value);
    if (value == 0) return std::memcpy(to, "0.0", 3), to + 3;
    const Decimal d = shortest(value);
    // 17 digits, which most numbers have but for one
    const bool all = d.digits >= tens_whole[16];
    std::uint64_t digits = d.digits + (9 * d.digits & (std::uint64_t(all) - 1));
    int point = d.exponent + 16 + all;  // digits before the point
    for (; digits < tens_whole[16]; --point) digits *= 10;
    const std::uint64_t first = digits / tens_whole[8], second = digits % tens_whole[8];  // 9 and 8
    const char lead = char('0' + first / tens_whole[8]);
    const auto [high, low] = digits_of(first % tens_whole[8], second);
    const int count = 17 - (low ? std::countl_zero(low) : 64 + std::countl_zero(high)) / 8;  // without zeros at the end

    constexpr int longest = sizeof(Real) == 8 ? 16 : 13, least = sizeof(Real) == 8 ? -5 : -6;
    if (least < point && point <= 0) {
        std::memcpy(to, "0.000000", 8), to += 2 - point;
        *to = lead, put_eight(to + 1, high), put_eight(to + 9, low);
        return to + count;
    }
    // the rest goes behind the point first, and what of it stands before the point over it
    to[0] = lead, to[1] = '.', put_eight(to + 2, high), put_eight(to + 10, low);
    if (0 < point && point <= longest) {
        const bool late = point > 8;
        if (late) put_eight(to + 1, high);
        const int shift = 8 * (point - 1 - 8 * late);
        const std::uint64_t part = (late ? low : high) | zeros, before = (1ull << shift) - 1;
        const std::uint64_t with_point = (part & before) | std::uint64_t('.') << shift | (part & ~before) << 8;
        std::memcpy(to + 1 + 8 * late, &with_point, 8);
        return to + 1 + std::max(count, point + 1);
    }
    to += count > 1 ? count + 1 : 1;
    *to++ = 'e', *to++ = point > 0 ? '+' : '-';
    return put_whole(to, std::uint64_t(std::abs(point - 1)));
}

}  // namespace jink::inline JINK_LEVEL::text
