// The rows of a table as text: JSON Lines or CSV.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "text/arrow.hpp"

namespace jink::inline JINK_LEVEL::text {

enum class Format { json, csv };

// Bytes with room behind them, so that the first can be copied all at once.
struct Snippet {
    static constexpr std::size_t at_once = 32;
    std::string held;
    std::size_t size = 0;

    void set(std::string_view text) {
        size = text.size(), held.assign(text);
        held.resize(std::max(size, at_once));
    }
    char *put(char *to) const {  // writes `at_once` bytes at least
        std::memcpy(to, held.data(), at_once);
        if (size > at_once) std::memcpy(to + at_once, held.data() + at_once, size - at_once);
        return to + size;
    }
};

// What a value that is no text becomes.
struct Cell {
    char text[47];
    std::uint8_t size;
};

struct Column {
    static constexpr std::int64_t stretch = 32;  // rows whose cells are made at once, a column after the other

    char kind;             // first letter of Arrow's format; D is a date
    std::int64_t unit;     // of a moment: how many a second
    char numbers;          // kind of the numbers of a categorical column's texts, or 0
    Snippet before;        // a value: the comma, the key
    const ArrowArray *array;
    std::int64_t offset;   // of the batch's first row
    std::array<Cell, stretch> cells;
    TextView last;         // the text before,
    Snippet written;       // what was made of it,
    bool repeats;          // and whether both are of this batch
};

// Takes a table as a stream of batches and makes its rows one at a time.
class Rows {
public:
    // The stream must live as long as this. header: first a row of the columns' names; of CSV.
    Rows(ArrowArrayStream *stream, Format format, bool header);

    bool supported() const { return supported_; }  // false: a column is of a kind that this does not write
    std::size_t fill(char *to, std::size_t size);  // bytes of the text from where the call before ended; none: it is at its end

private:
    void begin(bool header, const ArrowSchema &schema);
    bool next_batch();
    bool next_row();
    void make_cells(Column &column);
    template <class N, class Put> void make_each(Column &column, Put put);
    char *put_text(Column &column, char *to);
    char *put_quoted(std::string_view text, char *to) const;
    char *room(std::size_t size, char *to);

    ArrowArrayStream *stream_;
    Format format_;
    bool supported_ = true;
    std::vector<Column> columns_;
    Held<ArrowArray> batch_;
    std::int64_t row_ = 0, made_until_ = 0;  // of the batch: the next row, and the end of the cells
    std::size_t fixed_ = 0;                  // bytes of a row besides its texts, at most
    std::vector<char> made_;                 // a row,
    std::size_t size_ = 0, at_ = 0;          // its bytes, and how many are handed over
};

}  // namespace jink::inline JINK_LEVEL::text
