// Text to members of gzip files.
#include "bindings/bindings.hpp"
#include "packing/huffman.hpp"

namespace {

// A whole member: header, deflate stream, checksum (CRC-32) and size.
nb::bytes huffman_member(nb::bytes text, std::uint32_t checksum) {
    const auto *from = reinterpret_cast<const unsigned char *>(text.c_str());
    const std::size_t size = text.size();
    constexpr unsigned char header[10] = {0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 4, 255};  // deflate, no name, no time, packed fast
    std::unique_ptr<packing::Huffman> packed;
    std::size_t bytes = 0;
    {
        nb::gil_scoped_release released;
        packed = std::make_unique<packing::Huffman>(from, size);
        bytes = packed->bytes();
    }
    PyObject *made = PyBytes_FromStringAndSize(nullptr, Py_ssize_t(sizeof header + bytes + packing::spare));
    if (!made) throw std::bad_alloc();
    auto *out = reinterpret_cast<unsigned char *>(PyBytes_AS_STRING(made));
    {
        nb::gil_scoped_release released;
        std::memcpy(out, header, sizeof header);
        packed->write(out + sizeof header);
        const std::uint32_t trailer[2] = {checksum, std::uint32_t(size)};
        static_assert(sizeof trailer == packing::spare);
        std::memcpy(out + sizeof header + bytes, trailer, sizeof trailer);
    }
    return nb::steal<nb::bytes>(made);
}

}  // namespace

void bind_packing(nb::module_ &module) { module.def("huffman_member", huffman_member, "text"_a, "checksum"_a); }
