// The Python face of live targets that come and go.
#include "bindings/live_checks.hpp"
#include "bindings/live_results.hpp"
#include "run/live_slots.hpp"

namespace {

class LiveSlots : public Slots {
  public:
    using Slots::Slots;
    using Index = nb::ndarray<const std::int32_t, nb::c_contig, nb::device::cpu>;

    // Rows of any slots, those of one slot in the order of time; results as those of LiveMany, a row each.
    void update_rows(Index slots, Const t, Const z, nb::list results) {
        const std::size_t rows = slots.size(), columns = c->declared.columns();
        if (slots.ndim() != 1) throw wrong("slots: expected whole numbers (N,)");
        if (!has_shape(t, {rows})) throw wrong("t: expected shape (" + std::to_string(rows) + ",), got " + shape_of(t));
        if (!has_shape(z, {rows, columns})) throw wrong("z: expected shape (" + std::to_string(rows) + ", " + std::to_string(columns) + "), got " + shape_of(z));
        for (std::size_t k = 0; k < rows; ++k) check_time(t.data()[k]);
        for (std::size_t k = 0; k < rows * columns; ++k)
            if (std::isinf(z.data()[k])) throw wrong("z: is infinite; a missing component is NaN or None");
        double *pointers[7] = {};
        const std::size_t n = c->reported.n, sizes[7] = {n, n * n, std::size_t(c->members()), 1, 1, 1, 1};
        for (int k = 0; k < 7; ++k) {
            if (results[k].is_none()) continue;
            const Doubles array = nb::cast<Doubles>(results[k], false);
            if (array.size() != rows * sizes[k]) throw wrong("results: have another size than the rows");
            pointers[k] = array.data();
        }
        const auto status = nb::cast<nb::ndarray<unsigned char, nb::c_contig, nb::device::cpu>>(results[7], false);
        if (status.size() != rows) throw wrong("results: have another size than the rows");
        nb::gil_scoped_release released;
        const std::lock_guard lock(busy);
        for (std::size_t k = 0; k < rows; ++k) check_slot(slots.data()[k]);
        Combine<Pack> combine(*c);
        Snapshot<Pack> s;
        for (std::size_t first = 0; first < rows;) {
            const std::int32_t *slot = slots.data() + first;
            int some = 1;
            while (first + some < rows && some < lanes && std::find(slot, slot + some, slot[some]) == slot + some) ++some;
            step_rows(slot, some, t.data() + first, z.data() + first * columns, s);
            write_results(*c, s, combine, int(first), some, pointers, status.data());
            first += some;
        }
    }

    void check_slot(int slot) const {
        if (!taken(slot)) throw wrong("slot: " + std::to_string(slot) + " is not in use");
    }
};

}  // namespace

void bind_slots(nb::module_ &module, nb::class_<Engine> &engine) {
    engine.def("slots", [](const Engine &e) { return new LiveSlots(e.pack); });

    nb::class_<LiveSlots>(module, "LiveSlots")
        .def("begin_all",
             [](LiveSlots &live, Const x, Const P) {
                 check_state(x, P, NAN, live.c->reported.n);
                 const std::lock_guard lock(live.busy);
                 live.begin_all(x.data(), P.data());
             },
             "x"_a, "P"_a, "Let new targets start from a given state.")
        .def("take",
             [](LiveSlots &live) {
                 const std::lock_guard lock(live.busy);
                 return live.take();
             },
             "A slot for a new target.")
        .def("release",
             [](LiveSlots &live, int slot) {
                 const std::lock_guard lock(live.busy);
                 live.check_slot(slot);
                 live.release(slot);
             },
             "slot"_a, "The slot's target has gone.")
        .def_prop_ro("in_use",
                     [](const LiveSlots &live) {
                         const std::lock_guard lock(live.busy);
                         return live.in_use();
                     })
        .def("update", &LiveSlots::update_rows, "slots"_a, "t"_a, "z"_a, "results"_a);
}
