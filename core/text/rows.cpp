#include "text/rows.hpp"

#include <stdexcept>

#include "text/decimal.hpp"
#include "text/moments.hpp"

namespace jink::inline JINK_LEVEL::text {

namespace {

bool bit(const void *bits, std::int64_t row) { return static_cast<const std::uint8_t *>(bits)[row >> 3] >> (row & 7) & 1; }

bool known(const ArrowArray &array, std::int64_t row) { return !array.null_count || !array.buffers[0] || bit(array.buffers[0], row); }

// The number of a categorical column's text.
std::int64_t number(char kind, const void *numbers, std::int64_t row) {
    if (kind == 'C') return static_cast<const std::uint8_t *>(numbers)[row];
    if (kind == 'S') return static_cast<const std::uint16_t *>(numbers)[row];
    return static_cast<const std::uint32_t *>(numbers)[row];
}

template <std::size_t N> char *word(char *to, const char (&text)[N]) { return std::memcpy(to, text, N - 1), to + N - 1; }

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
        supported_ &= column.kind && (!texts || (column.kind == 'v' && std::strchr("CSI", column.numbers)));
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
        fixed_ += std::max(columns_[c].before.size, Snippet::at_once) + sizeof(Cell);
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
    row_ = made_until_ = 0;
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
    if (row_ == made_until_) {
        made_until_ = std::min(row_ + Column::stretch, batch_.length);
        for (Column &column : columns_) make_cells(column);
    }
    char *to = made_.data();
    for (Column &column : columns_) {
        to = column.before.put(to);
        const Cell &cell = column.cells[std::size_t(row_ % Column::stretch)];
        if (column.kind == 'v') to = put_text(column, to);
        else std::memcpy(to, cell.text, sizeof cell.text), to += cell.size;
    }
    if (format_ == Format::json) *to++ = '}';
    *to++ = '\n';
    ++row_, at_ = 0, size_ = std::size_t(to - made_.data());
    return true;
}

template <class N, class Put> void Rows::make_each(Column &column, Put put) {
    const ArrowArray &array = *column.array;
    for (std::int64_t row = row_; row < made_until_; ++row) {
        Cell &cell = column.cells[std::size_t(row % Column::stretch)];
        char *to = cell.text;
        const std::int64_t at = column.offset + row;
        if (column.kind != 'n' && known(array, at)) {
            if constexpr (std::is_same_v<N, bool>) to = put(to, bit(array.buffers[1], at));
            else to = put(to, static_cast<const N *>(array.buffers[1])[at]);
        } else if (format_ == Format::json) to = word(to, "null");
        cell.size = std::uint8_t(to - cell.text);
    }
}

void Rows::make_cells(Column &column) {
    const bool json = format_ == Format::json;
    const auto whole = [](char *to, auto n) {
        using Widest = std::conditional_t<std::is_signed_v<decltype(n)>, std::int64_t, std::uint64_t>;
        return put_whole(to, Widest(n));
    };
    const auto real = [json](char *to, auto x) {
        if (std::isfinite(x)) return put_real(to, x);
        return json ? word(to, "null") : std::isnan(x) ? word(to, "NaN") : x > 0 ? word(to, "inf") : word(to, "-inf");
    };
    const auto moment = [json, &column](char *to, auto n) {
        if (json) *to++ = '"';
        to = column.kind == 'D' ? put_date(to, n) : put_time(to, n, column.unit);
        return *to = '"', to + json;
    };
    switch (column.kind) {
    case 'g': return make_each<double>(column, real);
    case 'f': return make_each<float>(column, real);
    case 'c': return make_each<std::int8_t>(column, whole);
    case 'C': return make_each<std::uint8_t>(column, whole);
    case 's': return make_each<std::int16_t>(column, whole);
    case 'S': return make_each<std::uint16_t>(column, whole);
    case 'i': return make_each<std::int32_t>(column, whole);
    case 'I': return make_each<std::uint32_t>(column, whole);
    case 'l': return make_each<std::int64_t>(column, whole);
    case 'L': return make_each<std::uint64_t>(column, whole);
    case 'D': return make_each<std::int32_t>(column, moment);
    case 't': return make_each<std::int64_t>(column, moment);
    case 'n': case 'b': return make_each<bool>(column, [](char *to, bool yes) { return yes ? word(to, "true") : word(to, "false"); });
    }
}

char *Rows::put_text(Column &column, char *to) {
    const ArrowArray &array = *column.array, &texts = column.numbers ? *array.dictionary : array;
    std::int64_t row = column.offset + row_;
    if (!known(array, row)) return format_ == Format::json ? word(to, "null") : to;
    if (column.numbers) row = texts.offset + number(column.numbers, array.buffers[1], row);
    const TextView &view = static_cast<const TextView *>(texts.buffers[1])[row];
    if (column.repeats && !std::memcmp(&view, &column.last, sizeof view)) return column.written.put(room(std::max(column.written.size, Snippet::at_once), to));
    const char *from = view.size <= 12 ? view.head : static_cast<const char *>(texts.buffers[2 + view.buffer]) + view.offset;
    to = room(6 * std::size_t(view.size) + 2, to);
    char *end = put_quoted({from, std::size_t(view.size)}, to);
    column.last = view, column.written.set({to, std::size_t(end - to)}), column.repeats = true;
    return end;
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

}  // namespace jink::inline JINK_LEVEL::text
