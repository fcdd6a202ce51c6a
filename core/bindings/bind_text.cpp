// Tables as text: what `io/text_tables.py` hands to files.
#include "bindings/bindings.hpp"
#include "text/rows.hpp"

namespace {

using Bytes = nb::ndarray<std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// Rows, and the stream that they come from: of any table that has one.
struct TextRows {
    nb::capsule stream;
    text::Rows rows;

    TextRows(nb::object table, text::Format format, bool header)
        : stream(nb::cast<nb::capsule>(table.attr("__arrow_c_stream__")())),
          rows(static_cast<ArrowArrayStream *>(stream.data("arrow_array_stream")), format, header) {}

    std::size_t fill(Bytes to) {
        nb::gil_scoped_release released;
        return rows.fill(reinterpret_cast<char *>(to.data()), to.size());
    }
};

}  // namespace

void bind_text(nb::module_ &module) {
    nb::enum_<text::Format>(module, "TextFormat").value("json", text::Format::json).value("csv", text::Format::csv);
    nb::class_<TextRows>(module, "TextRows")
        .def(nb::init<nb::object, text::Format, bool>(), "table"_a, "format"_a, "header"_a)
        .def_prop_ro("supported", [](const TextRows &text) { return text.rows.supported(); })
        .def("fill", &TextRows::fill, "to"_a);
}
