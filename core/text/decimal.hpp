// Numbers as text: the shortest that reads back as the same number, bit for bit.
//
// Raffaello Giulietti, "The Schubfach way to render doubles" (2020): of the decimals that lie in the interval which rounds to x, one of the fewest
// digits, of these the closest to x.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace jink::text {

using Wide = unsigned __int128;

// 10^k = g 2^e for k in [-292, 324], rounded up to 128 bits of which the first is set.
struct TensTable {
    static constexpr int first = -292, last = 324;
    std::array<Wide, last - first + 1> g{};

    constexpr TensTable() {
        constexpr int words = 34;
        std::array<std::uint32_t, words> number{};  // little-endian
        number[0] = 1;
        for (int k = 0; k <= last; ++k) {
            std::uint64_t carry = 0;
            g[k - first] = top(number.data(), words);
            for (auto &word : number) carry += 5ull * word, word = std::uint32_t(carry), carry >>= 32;
        }
        number = {};
        number[words - 1] = 1;  // 2^1056, divided by 5^-k, of which 378 bits are left
        for (int k = -1; k >= first; --k) {
            std::uint64_t rest = 0;
            for (int w = words; w-- > 0;) rest = rest << 32 | number[w], number[w] = std::uint32_t(rest / 5), rest %= 5;
            g[k - first] = top(number.data(), words, 1);  // never exact
        }
    }

    // The first 128 bits of a number, rounded up where it has more.
    static constexpr Wide top(const std::uint32_t *number, int words, bool more = false) {
        while (number[words - 1] == 0) --words;
        Wide out = 0;
        for (int w = words - 1; w >= words - 4; --w) out = out << 32 | (w < 0 ? 0u : number[w]);
        const int shift = std::countl_zero(number[words - 1]);
        if (shift) out = out << shift | (words < 5 ? 0u : number[words - 5] >> (32 - shift));
        if (shift && words >= 5) more |= std::uint32_t(number[words - 5] << shift) != 0;
        else if (words >= 5) more |= number[words - 5] != 0;
        for (int w = 0; w < words - 5; ++w) more |= number[w] != 0;
        return out + more;
    }
};

inline constexpr TensTable tens;

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
    if (s >= 10) {
        const std::uint64_t tenth = s / 10;
        const bool below = from <= 40 * tenth, above = 40 * tenth + 40 <= to;
        if (below != above) return {tenth + above, k + 1};
    }
    const bool below = from <= 4 * s, above = 4 * s + 4 <= to;
    if (below != above) return {s + above, k};
    const std::uint64_t half = 4 * s + 2;
    return {s + (middle > half || (middle == half && (s & 1))), k};
}

// Eight digits of a number below 10^8, the first in the lowest byte.
inline std::uint64_t eight_digits(std::uint64_t n) {
    n += ((1ull << 32) - 10000) * ((n * 0x68db8bb) >> 40);
    n += ((1ull << 16) - 100) * (((n * 0x147b) >> 19) & 0x7f0000007full);
    n += ((1ull << 8) - 10) * (((n * 0x67) >> 10) & 0xf000f000f000full);
    return __builtin_bswap64(n);
}

inline void put_eight(char *to, std::uint64_t digits) {
    digits |= 0x3030303030303030ull;
    std::memcpy(to, &digits, 8);
}

// Up to 20 digits; the end of them. Writes up to 24 bytes.
inline char *put_whole(char *to, std::uint64_t n) {
    if (n < 10) return *to = char('0' + n), to + 1;
    char all[24];
    put_eight(all, eight_digits(n / 10000000000000000ull));
    put_eight(all + 8, eight_digits(n / 100000000 % 100000000));
    put_eight(all + 16, eight_digits(n % 100000000));
    int skip = n < 100000000 ? 16 : n < 10000000000000000ull ? 8 : 0;
    while (all[skip] == '0') ++skip;
    std::memcpy(to, all + skip, 24 - skip);
    return to + 24 - skip;
}

inline char *put_whole(char *to, std::int64_t n) {
    if (n < 0) *to++ = '-';
    return put_whole(to, n < 0 ? 0 - std::uint64_t(n) : std::uint64_t(n));
}

// A finite number, with a point or an exponent: 1.0, 0.00012, 1e-7, 1.5e+22. Writes up to 40 bytes.
template <class Real> char *put_real(char *to, Real value) {
    if (std::signbit(value)) *to++ = '-', value = -value;
    if (value == 0) return std::memcpy(to, "0.0", 3), to + 3;
    const Decimal d = shortest(value);
    char all[48] = {};
    const std::uint64_t lead = d.digits / 10000000000000000ull;  // of 17 digits at most
    const std::uint64_t high = eight_digits(d.digits / 100000000 % 100000000), low = eight_digits(d.digits % 100000000);
    all[7] = char('0' + lead);
    put_eight(all + 8, high), put_eight(all + 16, low);
    const int begin = lead ? 7 : high ? 8 + std::countr_zero(high) / 8 : 16 + std::countr_zero(low) / 8;
    const int end = low ? 24 - std::countl_zero(low) / 8 : high ? 16 - std::countl_zero(high) / 8 : 8;
    const char *digits = all + begin;
    const int count = end - begin, point = d.exponent + 24 - begin;  // digits before the point
    constexpr int longest = sizeof(Real) == 8 ? 16 : 13, least = sizeof(Real) == 8 ? -5 : -6;
    if (0 < point && point <= longest) {
        std::memcpy(to, "0000000000000000", 16);
        if (count <= point) {
            std::memcpy(to, digits, count), std::memcpy(to + point, ".0", 2);
            return to + point + 2;
        }
        std::memcpy(to, digits, 17);
        std::memmove(to + point + 1, digits + point, 17);
        return to[point] = '.', to + count + 1;
    }
    if (least < point && point <= 0) {
        std::memcpy(to, "0.000000", 8);
        std::memcpy(to + 2 - point, digits, 17);
        return to + 2 - point + count;
    }
    *to++ = digits[0];
    if (count > 1) *to = '.', std::memcpy(to + 1, digits + 1, 16), to += count;
    *to++ = 'e', *to++ = point > 0 ? '+' : '-';
    return put_whole(to, std::uint64_t(std::abs(point - 1)));
}

}  // namespace jink::text
