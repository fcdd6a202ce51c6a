// The rows of many tracks on their way into the lanes of a pack, and results on their way out, a block of scans at a time.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>

#include "run/batch.hpp"
#include "number/transpose.hpp"

namespace jink::inline JINK_LEVEL {

inline constexpr int block = 32;  // scans gathered and scattered at a time, so that both read and write runs of memory

// Which rows of the flat arrays the lanes of a pack own.
struct Span {
    std::int64_t start[lanes], count[lanes];
    bool all_live(std::int64_t from, int scans) const {
        return std::all_of(count, count + lanes, [&](std::int64_t n) { return n >= from + scans; });
    }
    int live(int l, std::int64_t from, int scans) const { return int(std::clamp<std::int64_t>(count[l] - from, 0, scans)); }
};

// One kind of input on its way in: a block of scans of every lane's rows, turned into packs.
class Stream {
  public:
    Stream(const double *source, int values, double filler)
        : from(source), n(values), fill(filler), buffer(source ? std::size_t(block) * n * lanes : 0) {}

    Pack at(int k, int c) const { return load<Pack>(&buffer[(k * n + c) * lanes]); }

    void gather(const Span &rows, std::int64_t scan, int scans) {
        if (!from) return;
        if (rows.all_live(scan, scans)) {
            const double *lane_of[lanes];
            for (int l = 0; l < lanes; ++l) lane_of[l] = from + (rows.start[l] + scan) * n;
            to_lanes(lane_of, std::int64_t(scans) * n, buffer.data());
            return;
        }
        for (int l = 0; l < lanes; ++l) {
            const int live = rows.live(l, scan, scans) * n;
            const double *source = from + (rows.start[l] + scan) * n;
            for (int k = 0; k < scans * n; ++k) buffer[k * lanes + l] = k < live ? source[k] : fill;
        }
    }

  private:
    const double *from;
    int n;
    double fill;
    std::vector<double> buffer;
};

// The rows of one pack of tracks, a block of scans at a time.
class Rows {
  public:
    Rows(const BatchInput &batch, int state_axes)
        : in(batch), axes(state_axes), time(in.time, 1, 0.0), z(in.z, in.columns, NAN),
          noise(in.noise, in.full_noise ? in.columns * in.columns : in.columns, 1.0), input(in.input, axes, 0.0) {
        for (const NoiseColumn &each : in.noise_columns) noise_columns.emplace_back(each.values, 1, each.row == each.column ? 1.0 : 0.0);
    }

    Span span;

    // The lanes' tracks, `used` of them; returns how long the longest is.
    std::int64_t take(const std::int64_t *tracks, int used) {
        std::int64_t longest = 0;
        auto &[first, length] = span;
        for (int l = 0; l < lanes; ++l) {
            const std::int64_t b = tracks[std::min(l, used - 1)];
            first[l] = in.offsets[b];
            length[l] = l < used ? in.offsets[b + 1] - in.offsets[b] : 0;
            longest = std::max(longest, length[l]);
        }
        suspect = splat_mask<Pack>(false), latest = splat<Pack>(-std::numeric_limits<double>::max());
        return longest;
    }

    // After the last scan. Errors: std::invalid_argument naming a row whose time goes back or is none, or that is infinite.
    void verify(const std::int64_t *tracks, int used) const {
        if (!any(suspect)) return;
        for (int l = 0; l < used; ++l) complain(tracks[l]);
    }

    void gather(std::int64_t from, int scans) {
        begun = from;
        for (Stream *stream : {&time, &z, &noise, &input}) stream->gather(span, from, scans);
        for (Stream &stream : noise_columns) stream.gather(span, from, scans);
    }

    // The k-th scan of the block.
    void read(int k, Scan<Pack> &scan, Pack *known) {
        scan.time = time.at(k, 0);
        for (int r = 0; r < in.columns; ++r) scan.z[r] = z.at(k, r);
        scan.own_noise = in.noise || !noise_columns.empty(), scan.own_full = in.full_noise;
        for (int r = 0; in.noise && r < in.columns; ++r) {
            if (!in.full_noise) scan.R[r] = noise.at(k, r);
            for (int q = 0; in.full_noise && q <= r; ++q) scan.R[packed(r, q)] = noise.at(k, r * in.columns + q);
        }
        if (!noise_columns.empty()) read_noise_columns(k, scan.R);
        for (int a = 0; in.input && a < axes; ++a) known[a] = input.at(k, a);
        scan.input = in.input ? known : nullptr;
        PackMask lengths;
        std::memcpy(&lengths, span.count, sizeof lengths);
        scan.active = lengths > begun + k;
        look_at(scan);
        if (!in.sensor) return;
        for (int l = 0; l < lanes; ++l)
            which[l] = begun + k < span.count[l] ? in.sensor[span.start[l] + begun + k] : l ? which[0] : 0;
        scan.one_sensor = which[0];
        scan.sensor = std::any_of(which, which + lanes, [&](auto s) { return s != which[0]; }) ? which : nullptr;
    }

  private:
    const BatchInput &in;
    int axes;
    std::int64_t begun = 0;
    Stream time, z, noise, input;
    std::vector<Stream> noise_columns;
    std::int32_t which[lanes];

    Mask<Pack> suspect;
    Pack latest;

    void read_noise_columns(int k, Pack *R) const {
        std::fill_n(R, in.full_noise ? packed_size(in.columns) : in.columns, splat<Pack>(0.0));
        for (std::size_t e = 0; e < noise_columns.size(); ++e) {
            const NoiseColumn &at = in.noise_columns[e];
            R[in.full_noise ? packed(at.row, at.column) : at.row] = noise_columns[e].at(k, 0);
        }
    }

    // Times must not go back within a track, and infinite measurements mean nothing.
    void look_at(const Scan<Pack> &scan) {
        const Pack most = splat<Pack>(std::numeric_limits<double>::max());
        suspect = suspect | (scan.active & inverse((scan.time >= latest) & (scan.time <= most)));
        for (int r = 0; r < in.columns; ++r) suspect = suspect | (magnitude(scan.z[r]) > most);
        latest = scan.time;
    }

    // The row that is wrong, in words.
    void complain(std::int64_t track) const {
        const std::int64_t from = in.offsets[track], to = in.offsets[track + 1];
        for (std::int64_t k = from; k < to; ++k) {
            const std::string row = "row " + std::to_string(k);
            if (!std::isfinite(in.time[k])) throw std::invalid_argument("time: " + row + " of track " + std::to_string(track) + " is not a time");
            if (k > from && in.time[k] < in.time[k - 1])
                throw std::invalid_argument("time: " + row + " of track " + std::to_string(track) +
                                            " lies before the row before it; rows of a track must be in the order of time");
            for (int r = 0; r < in.columns; ++r)
                if (std::isinf(in.z[k * in.columns + r]))
                    throw std::invalid_argument("z: " + row + " is infinite; a missing component is NaN or None");
        }
    }
};

// One kind of result on its way out: a block of scans in packs, turned into the rows of each track.
class Column {
  public:
    Column(double *to, std::int64_t rows, int values, bool symmetric = false)
        : dest(to), n(symmetric ? values * values : values), large(rows * n > (1 << 20)), buffer(to ? std::size_t(block) * n * lanes : 0) {
        for (int e = 0; e < n; ++e) source.push_back(symmetric ? packed(e / values, e % values) : e);
    }

    bool wanted() const { return dest != nullptr; }
    void put(int k, const Pack *values, Mask<Pack> valid) {
        for (int e = 0; e < n; ++e) store(&buffer[(k * n + e) * lanes], select<Pack>(valid, values[source[e]], nan_of<Pack>()));
    }

    void scatter(const Span &rows, std::int64_t from, int scans) const {
        if (!dest) return;
        double *to[lanes];
        for (int l = 0; l < lanes; ++l) to[l] = dest + (rows.start[l] + from) * n;
        if (rows.all_live(from, scans)) return from_lanes(buffer.data(), std::int64_t(scans) * n, to, large);
        for (int l = 0; l < lanes; ++l) {
            const int live = rows.live(l, from, scans) * n;
            for (int k = 0; k < live; ++k) to[l][k] = buffer[k * lanes + l];
        }
    }

  private:
    double *dest;
    int n;
    bool large;  // more than the caches hold
    std::vector<double> buffer;
    std::vector<int> source;  // of each element among the packed values
};

// Some elements of a packed result, each on its way to an array of its own.
class Elements {
  public:
    Elements(const std::vector<Covariance> &wanted, std::int64_t rows)
        : to(wanted), large(rows > (1 << 20)), buffer(wanted.size() * block * lanes) {}

    bool wanted() const { return !to.empty(); }
    void put(int k, const Pack *values, Mask<Pack> valid) {
        for (std::size_t e = 0; e < to.size(); ++e)
            store(&buffer[(e * block + k) * lanes], select<Pack>(valid, values[packed(to[e].row, to[e].column)], nan_of<Pack>()));
    }

    void scatter(const Span &rows, std::int64_t from, int scans) const {
        for (std::size_t e = 0; e < to.size(); ++e) {
            const double *values = &buffer[e * block * lanes];
            double *dest[lanes];
            for (int l = 0; l < lanes; ++l) dest[l] = to[e].to + rows.start[l] + from;
            if (rows.all_live(from, scans)) {
                from_lanes(values, scans, dest, large);
                continue;
            }
            for (int l = 0; l < lanes; ++l)
                for (int k = 0; k < rows.live(l, from, scans); ++k) dest[l][k] = values[k * lanes + l];
        }
    }

  private:
    std::vector<Covariance> to;
    bool large;  // more than the caches hold
    std::vector<double> buffer;
};

}  // namespace jink::inline JINK_LEVEL
