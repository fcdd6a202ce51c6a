// Places on the earth and in the plane: what `io/geodesy.py` asks of many rows at once.
#include "bindings/bindings.hpp"
#include "models/geodesic.hpp"

namespace {

using Column = nb::ndarray<const double, nb::ndim<1>, nb::device::cpu>;
using Table = nb::ndarray<nb::numpy, double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// A table of columns (m, N), which nobody has set to zero first.
struct Fresh {
    std::size_t columns, count;
    std::unique_ptr<double[]> values = std::make_unique_for_overwrite<double[]>(columns * count);
    double *operator[](std::size_t column) { return values.get() + column * count; }
    Table table() {
        double *held = values.release();
        return Table(held, {columns, count}, nb::capsule(held, [](void *p) noexcept { delete[] static_cast<double *>(p); }));
    }
};

double value(const Column &of, std::size_t k) { return of.data()[std::int64_t(k) * of.stride(0)]; }

// `lanes` rows of a column from row k; past the end the last one again.
Pack rows_of(const Column &of, std::size_t k) {
    if (of.stride(0) == 1 && k + lanes <= of.size()) return load<Pack>(of.data() + k);
    double lane[lanes];
    for (int l = 0; l < lanes; ++l) lane[l] = value(of, std::min(k + l, of.size() - 1));
    return load<Pack>(lane);
}

void put(double *to, Pack found, std::size_t k, std::size_t count) {
    if (k + lanes <= count) return store(to + k, found);
    for (std::size_t l = 0; k + l < count; ++l) to[k + l] = found[l];
}

template <class... Others> std::size_t rows(const char *what, const Column &first, const Others &...others) {
    if (((others.size() != first.size()) || ...)) throw nb::value_error(what);
    return first.size();
}

// Geodesics between places (N,): their directions from north at the start, by how much the meridian turns against them on the way (rad), and
// lengths (m): (3, N).
Table geodesics_between(Column latitude, Column longitude, Column to_latitude, Column to_longitude) {
    const std::size_t count = rows("geodesics_between: expected as many ends as starts", latitude, longitude, to_latitude, to_longitude);
    Fresh out{3, count};
    {
        nb::gil_scoped_release released;
        for (std::size_t k = 0; k < count; k += lanes) {
            const Leg<Pack> leg = geodesic_between<Pack>(rows_of(latitude, k), rows_of(longitude, k), rows_of(to_latitude, k), rows_of(to_longitude, k));
            const Pack start = wrapped<Pack>(arc_tangent<Pack>(leg.east, leg.north) - 0.5 * leg.turned);
            put(out[0], start, k, count), put(out[1], leg.turned, k, count), put(out[2], leg.length(), k, count);
        }
    }
    return out.table();
}

// Where geodesics end that start at anchors (N,), with the way in a plane turned against north: latitude, longitude, turn there (3, N).
Table geodesics_ahead(Column x, Column y, Column anchor_x, Column anchor_y, Column latitude, Column longitude, Column convergence) {
    const std::size_t count = rows("geodesics_ahead: expected an anchor of each row", x, y, anchor_x, anchor_y, latitude, longitude, convergence);
    Fresh out{3, count};
    {
        nb::gil_scoped_release released;
        for (std::size_t k = 0; k < count; k += lanes) {
            const Pack right = rows_of(x, k) - rows_of(anchor_x, k), up = rows_of(y, k) - rows_of(anchor_y, k), turn = rows_of(convergence, k);
            Pack sine, cosine;
            sine_cosine<Pack>(turn, sine, cosine);
            const Arrival<Pack> end = geodesic_ahead<Pack>(rows_of(latitude, k), rows_of(longitude, k), right * cosine + up * sine, up * cosine - right * sine);
            put(out[0], end.latitude, k, count), put(out[1], end.longitude, k, count), put(out[2], turn + end.turned, k, count);
        }
    }
    return out.table();
}

// The legs of tracks, from each known position to the one before it, in rows 0 to 2 of a table (7, N) that `laid` completes: zeros where a track
// begins, NaN where no position is known. Also the rows (K, 2) that legs longer than `longest` (m) join.
nb::tuple legs(Column latitude, Column longitude, Flags first, double longest) {
    const std::size_t count = rows("legs: expected as many longitudes as latitudes", latitude, longitude);
    if (first.size() != count) throw nb::value_error("legs: expected a mark of each row");
    Fresh out{7, count};
    std::vector<std::int64_t> beyond;
    {
        nb::gil_scoped_release released;
        std::size_t before[lanes] = {}, row[lanes] = {}, waiting = 0;
        const auto set = [&](std::size_t k, double east, double north, double turned) { out[0][k] = east, out[1][k] = north, out[2][k] = turned; };
        const auto flush = [&] {
            double from[2][lanes], to[2][lanes];
            for (int l = 0; l < lanes; ++l) {
                from[0][l] = value(latitude, before[l]), from[1][l] = value(longitude, before[l]);
                to[0][l] = value(latitude, row[l]), to[1][l] = value(longitude, row[l]);
            }
            const Leg<Pack> leg = geodesic_between<Pack>(load<Pack>(from[0]), load<Pack>(from[1]), load<Pack>(to[0]), load<Pack>(to[1]));
            const Pack length = leg.length();
            for (std::size_t l = 0; l < waiting; ++l) {
                set(row[l], leg.east[l], leg.north[l], leg.turned[l]);
                if (length[l] > longest) beyond.insert(beyond.end(), {std::int64_t(before[l]), std::int64_t(row[l])});
            }
            waiting = 0;
        };
        bool begun = false;
        for (std::size_t k = 0, last = 0; k < count; ++k) {
            begun &= !first.data()[k];
            if (!std::isfinite(value(latitude, k)) || !std::isfinite(value(longitude, k))) {
                set(k, std::nan(""), std::nan(""), std::nan(""));
                continue;
            }
            if (begun) before[waiting] = last, row[waiting++] = k;
            else set(k, 0.0, 0.0, 0.0);
            begun = true, last = k;
            if (waiting == lanes) flush();
        }
        if (waiting) flush();
    }
    const std::size_t found = beyond.size() / 2;
    return nb::make_tuple(out.table(), array_of(std::move(beyond), {found, 2}));
}

// Lays such legs into the plane, in place: x and y (m), NaN where no position is known, and of the last known position, which is the row's own
// where it has one, x, y, latitude, longitude and the convergence there (rad).
void laid(Column latitude, Column longitude, Flags first, Table table) {
    const std::size_t count = rows("laid: expected as many longitudes as latitudes", latitude, longitude);
    if (first.size() != count || table.shape(0) != 7 || table.shape(1) != count) throw nb::value_error("laid: expected the table of these legs");
    nb::gil_scoped_release released;
    double *column[7];
    for (int c = 0; c < 7; ++c) column[c] = table.data() + c * count;
    double anchor[5] = {0.0, 0.0, std::nan(""), std::nan(""), 0.0};
    for (std::size_t k = 0; k < count; k += lanes) {
        const std::size_t block = std::min<std::size_t>(lanes, count - k);
        double turn[lanes] = {}, turned[lanes];
        for (std::size_t l = 0; l < block; ++l) {  // the meridian at the middle of each leg, and at its end
            const double change = column[2][k + l];
            if (first.data()[k + l]) anchor[4] = 0.0;
            turn[l] = anchor[4] + 0.5 * change;
            if (!std::isnan(change)) anchor[4] += change;
            turned[l] = anchor[4];
        }
        Pack sine, cosine;
        sine_cosine<Pack>(load<Pack>(turn), sine, cosine);
        for (std::size_t l = 0; l < block; ++l) {
            const std::size_t r = k + l;
            const double east = column[0][r], north = column[1][r];
            if (first.data()[r]) anchor[0] = anchor[1] = 0.0, anchor[2] = anchor[3] = std::nan("");
            if (!std::isnan(east)) {
                anchor[0] += east * cosine[l] - north * sine[l], anchor[1] += east * sine[l] + north * cosine[l];
                anchor[2] = value(latitude, r), anchor[3] = value(longitude, r);
            }
            column[0][r] = std::isnan(east) ? east : anchor[0], column[1][r] = std::isnan(east) ? east : anchor[1];
            for (int c = 0; c < 4; ++c) column[2 + c][r] = anchor[c];
            column[6][r] = turned[l];
        }
    }
}

}  // namespace

void bind_geodesy(nb::module_ &module) {
    module.attr("earth_equator") = Earth::equator;
    module.attr("earth_flattening") = Earth::flattening;
    module.def("geodesics_between", geodesics_between, "latitude"_a, "longitude"_a, "to_latitude"_a, "to_longitude"_a);
    module.def("geodesics_ahead", geodesics_ahead, "x"_a, "y"_a, "anchor_x"_a, "anchor_y"_a, "latitude"_a, "longitude"_a, "convergence"_a);
    module.def("legs", legs, "latitude"_a, "longitude"_a, "first"_a, "longest"_a);
    module.def("laid", laid, "latitude"_a, "longitude"_a, "first"_a, "table"_a);
}
