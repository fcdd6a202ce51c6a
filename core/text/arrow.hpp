// The Arrow C data interface: how other packages hand over a table without a copy.
#pragma once

#include <cstdint>

extern "C" {

struct ArrowSchema {
    const char *format, *name, *metadata;
    std::int64_t flags, n_children;
    ArrowSchema **children, *dictionary;
    void (*release)(ArrowSchema *);
    void *private_data;
};

struct ArrowArray {
    std::int64_t length, null_count, offset, n_buffers, n_children;
    const void **buffers;
    ArrowArray **children, *dictionary;
    void (*release)(ArrowArray *);
    void *private_data;
};

struct ArrowArrayStream {
    int (*get_schema)(ArrowArrayStream *, ArrowSchema *);
    int (*get_next)(ArrowArrayStream *, ArrowArray *);
    const char *(*get_last_error)(ArrowArrayStream *);
    void (*release)(ArrowArrayStream *);
    void *private_data;
};
}

namespace jink::inline JINK_LEVEL::text {

// Holds one of them, and gives it back.
template <class Struct> struct Held : Struct {
    Held() : Struct{} {}
    Held(const Held &) = delete;
    Held &operator=(const Held &) = delete;
    ~Held() { drop(); }
    void drop() {
        if (this->release) this->release(this);
        this->release = nullptr;
    }
};

// A text of 12 bytes at most lies in its view, a longer one in one of the column's buffers.
struct TextView {
    std::int32_t size;
    char head[4];
    std::int32_t buffer, offset;
};

}  // namespace jink::inline JINK_LEVEL::text
