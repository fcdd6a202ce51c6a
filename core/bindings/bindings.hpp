// What the parts of the Python face share.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "run/batch.hpp"
#include "run/engine.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using namespace jink;

using Vector = std::vector<double>;
using Doubles = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using Const = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// A NumPy array that owns these numbers.
template <class N> nb::object array_of(std::vector<N> &&values, std::initializer_list<std::size_t> shape) {
    auto *held = new std::vector<N>(std::move(values));
    nb::capsule owner(held, [](void *p) noexcept { delete static_cast<std::vector<N> *>(p); });
    return nb::cast(nb::ndarray<nb::numpy, N>(held->data(), shape.size(), shape.begin(), owner));
}

// What is not zero in the noise of `rows` measurements of `size` components: (row, column, values), from Python.
std::vector<NoiseColumn> noise_columns_of(nb::list columns, int size, std::size_t rows);

void bind_declarations(nb::module_ &module);                       // enumerations and named fields of a filter
void bind_checks(nb::module_ &module);                             // of many rows at once
void bind_scatter(nb::module_ &module);                            // what measurements show of their noise
void bind_manoeuvres(nb::module_ &module);                         // how likely targets manoeuvre
void bind_geodesy(nb::module_ &module);                            // places on the earth and in the plane
void bind_text(nb::module_ &module);                               // tables as text
void bind_live(nb::module_ &module, nb::class_<Engine> &engine);  // one scan at a time
void bind_slots(nb::module_ &module, nb::class_<Engine> &engine);  // live targets that come and go
void bind_stepwise(nb::module_ &module);                          // models of the user's own
void bind_population(nb::module_ &module);                        // learning
void bind_gradient(nb::module_ &module);
void bind_association(nb::module_ &module, nb::class_<Engine> &engine);  // many targets in clutter
