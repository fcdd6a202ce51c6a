#include <cstring>
#include <stdexcept>

#include "text/rows.hpp"

#include "text/decimal.hpp"
#include "text/moments.hpp"

namespace jink::text {

namespace {

constexpr std::size_t longest = 64;  // bytes of a value that is no text, with what is written past its end

template <class N> N value(const ArrowArray &array, std::int64_t row) { return static_cast<const N *>(array.buffers[1])[row]; }

bool bit(const void *bits, std::int64_t row) { return static_cast<const std::uint8_t *>(bits)[row >> 3] >> (row & 7) & 1; }

std::uint64_t whole(char kind, const ArrowArray &array, std::int64_t row) {
    switch (kind) {
    case 'c': return std::uint64_t(value<std::int8_t>(array, row));
    case 'C': return value<std::uint8_t>(array, row);
    case 's': return std::uint64_t(value<std::int16_t>(array, row));
    case 'S': return value<std::uint16_t>(array, row);
    case 'i': return std::uint64_t(value<std::int32_t>(array, row));
    case 'I': return value<std::uint32_t>(array, row);
    default: return value<std::uint64_t>(array, row);
    }
}

// The kind of a column, or 0 if it is none that is written here.
char kind_of(std::string_view format, std::int64_t &unit) {
    if (format == "vu") return 'v';
    if (format == "tdD") return 'D';
    if (format.size() == 1 && std::strchr("nbcCsSiIlLfg", format[0])) return format[0];
    if (format.size() < 4 || !format.starts_with("ts") || format[3] != ':') return 0;
    const std::string_view zone = format.substr(4);
    unit = format[2] == 'm' ? 1'000 : format[2] == 'u' ? 1'000'000 : format[2] == 'n' ? 1'000'000'000 : 0;
    return unit && (zone.empty() || zone == "UTC") ? 't' : 0;
}

}  // namespace

Rows::Rows(ArrowArrayStream *stream, Format format, bool header) : stream_(stream), format_(format) {
    Held<ArrowSchema> schema;
    if (stream->get_schema(stream, &schema)) throw std::runtime_error("the table has no schema");
    for (std::int64_t c = 0; c < schema.n_children; ++c) {
        const ArrowSchema &child = *schema.children[c], *texts = child.dictionary;
        Column column{};
        column.kind = kind_of(texts ? texts->format : child.format, column.unit);
        if (texts) column.numbers = child.format[0];
        supported_ &= column.kind && (!texts || column.kind == 'v');
        columns_.push_back(std::move(column));
    }
    supported_ &= schema.n_children > 0;
    begin(header, schema);
}

// What stands before each value, and the header.
void Rows::begin(bool header, const ArrowSchema &schema) {
    const bool json = format_ == Format::json;
    std::string names, before = json ? "{" : "";
    for (std::size_t c = 0; c < columns_.size(); ++c, before = ",") {
        const std::string_view name = schema.children[c]->name;
        std::string quoted(6 * name.size() + 2, 0);
        quoted.resize(std::size_t(put_quoted(name, quoted.data()) - quoted.data()));
        names += (c ? "," : "") + quoted;
        columns_[c].before.set(json ? before + quoted + ":" : before);
        fixed_ += std::max(columns_[c].before.size, Snippet::at_once) + longest;
    }
    if (header) names += '\n', made_.assign(names.begin(), names.end()), size_ = made_.size();
    made_.resize(std::max(size_, 2 * fixed_));
}

std::size_t Rows::fill(char *to, std::size_t size) {
    std::size_t filled = 0;
    while (filled < size && (at_ < size_ || next_row())) {
        const std::size_t count = std::min(size - filled, size_ - at_);
        std::memcpy(to + filled, made_.data() + at_, count);
        filled += count, at_ += count;
    }
    return filled;
}

bool Rows::next_batch() {
    batch_.drop();
    if (stream_->get_next(stream_, &batch_)) throw std::runtime_error(stream_->get_last_error(stream_));
    if (!batch_.release) return false;
    row_ = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
        columns_[c].array = batch_.children[c];
        columns_[c].offset = batch_.offset + batch_.children[c]->offset;
        columns_[c].repeats = false;
    }
    return true;
}

bool Rows::next_row() {
    while (!batch_.release || row_ == batch_.length)
        if (!next_batch()) return false;
    char *to = made_.data();
    for (Column &column : columns_) to = put(column, column.before.put(to));
    if (format_ == Format::json) *to++ = '}';
    *to++ = '\n';
    ++row_, at_ = 0, size_ = std::size_t(to - made_.data());
    return true;
}

char *Rows::put(Column &column, char *to) {
    const ArrowArray &array = *column.array;
    const std::int64_t row = column.offset + row_;
    const bool json = format_ == Format::json;
    const auto word = [&](const char *text) { return std::memcpy(to, text, std::strlen(text)), to + std::strlen(text); };
    const auto real = [&](auto x) { return std::isfinite(x) ? put_real(to, x) : word(json ? "null" : std::isnan(x) ? "NaN" : x > 0 ? "inf" : "-inf"); };
    if (column.kind == 'n' || (array.buffers[0] && array.null_count && !bit(array.buffers[0], row))) return json ? word("null") : to;
    switch (column.kind) {
    case 'g': return real(value<double>(array, row));
    case 'f': return real(value<float>(array, row));
    case 'b': return word(bit(array.buffers[1], row) ? "true" : "false");
    case 't': return put_moment(column, to, value<std::int64_t>(array, row));
    case 'D': return put_moment(column, to, value<std::int32_t>(array, row));
    case 'v':
        if (!column.numbers) return put_text(column, array, row, to);
        return put_text(column, *array.dictionary, array.dictionary->offset + std::int64_t(whole(column.numbers, array, row)), to);
    case 'c': case 's': case 'i': case 'l': return put_whole(to, std::int64_t(whole(column.kind, array, row)));
    default: return put_whole(to, whole(column.kind, array, row));
    }
}

char *Rows::put_text(Column &column, const ArrowArray &texts, std::int64_t row, char *to) {
    const TextView &view = static_cast<const TextView *>(texts.buffers[1])[row];
    if (column.repeats && !std::memcmp(&view, &column.last, sizeof view)) return column.written.put(room(std::max(column.written.size, Snippet::at_once), to));
    const char *from = view.size <= 12 ? view.head : static_cast<const char *>(texts.buffers[2 + view.buffer]) + view.offset;
    to = room(6 * std::size_t(view.size) + 2, to);
    char *end = put_quoted({from, std::size_t(view.size)}, to);
    column.last = view, column.written.set({to, std::size_t(end - to)}), column.repeats = true;
    return end;
}

char *Rows::put_moment(const Column &column, char *to, std::int64_t value) const {
    if (format_ == Format::json) *to++ = '"';
    to = column.kind == 'D' ? put_date(to, value) : put_time(to, value, column.unit);
    if (format_ == Format::json) *to++ = '"';
    return to;
}

// In JSON always in quotes, in CSV where it must be. Writes 6 bytes a byte and 2 more at most.
char *Rows::put_quoted(std::string_view text, char *to) const {
    const auto plain = [&](char each) {
        const auto byte = static_cast<unsigned char>(each);
        return format_ == Format::json ? byte >= 0x20 && each != '"' && each != '\\' : each != '"' && each != ',' && each != '\n' && each != '\r';
    };
    const bool bare = std::all_of(text.begin(), text.end(), plain);
    if (format_ == Format::csv && bare && !text.empty()) return std::copy(text.begin(), text.end(), to);
    *to++ = '"';
    if (bare) to = std::copy(text.begin(), text.end(), to);
    else if (format_ == Format::csv)
        for (char each : text) {
            if (each == '"') *to++ = '"';
            *to++ = each;
        }
    else
        for (char each : text) {
            static constexpr char from[] = "\"\\\b\f\n\r\t", into[] = "\"\\bfnrt";
            const char *found = each ? std::strchr(from, each) : nullptr;
            if (found) *to++ = '\\', *to++ = into[found - from];
            else if (plain(each)) *to++ = each;
            else std::memcpy(to, "\\u00", 4), to[4] = char('0' + (each >> 4)), to[5] = "0123456789abcdef"[each & 15], to += 6;
        }
    *to++ = '"';
    return to;
}

// A place for so many bytes, and for the rest of the row behind them.
char *Rows::room(std::size_t size, char *to) {
    const std::size_t used = std::size_t(to - made_.data());
    if (made_.size() < used + size + fixed_) made_.resize(2 * (used + size + fixed_));
    return made_.data() + used;
}

}  // namespace jink::text
