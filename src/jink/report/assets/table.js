// A table that sorts by any column, filters by text and draws its rows in portions as it is scrolled.
// columns: [{ title, unit(), values, text(i), numeric, meter, flag(i), hint }]; the first column is the name.

class SortableTable {
  constructor(host, columns, { onChoose, portion = 150 }) {
    Object.assign(this, { host, columns, onChoose, portion });
    this.sorted = { column: 0, descending: false };
    this.filter = "";
    this.chosen = -1;
    this.table = document.createElement("table");
    this.table.className = "grid";
    this.head = this.table.createTHead().insertRow();
    this.body = this.table.createTBody();
    host.append(this.table);
    host.addEventListener("scroll", () => {
      if (host.scrollTop + host.clientHeight > host.scrollHeight - 300) this.more();
    });
    this.body.addEventListener("click", (event) => {
      const row = event.target.closest("tr");
      if (row?.dataset.index) this.onChoose(Number(row.dataset.index));
    });
    this.body.addEventListener("keydown", (event) => this.key(event));
    this.drawHead();
    this.order();
  }

  drawHead() {
    this.head.replaceChildren(...this.columns.map((column, c) => {
      const cell = document.createElement("th");
      cell.scope = "col";
      const button = document.createElement("button");
      button.type = "button";
      if (column.hint) button.title = column.hint;
      const name = document.createElement("span");
      name.textContent = column.title;
      button.append(name);
      const unit = column.unit ? column.unit() : "";
      if (unit) button.append(Object.assign(document.createElement("small"), { textContent: unit }));
      button.addEventListener("click", () => this.sortBy(c));
      if (this.sorted.column === c) cell.setAttribute("aria-sort", this.sorted.descending ? "descending" : "ascending");
      cell.append(button);
      return cell;
    }));
  }

  sortBy(column) {
    const again = this.sorted.column === column;
    this.sorted = { column, descending: again ? !this.sorted.descending : Boolean(this.columns[column].numeric) };
    const focused = document.activeElement?.closest("th")?.cellIndex;
    this.drawHead();
    if (focused !== undefined) this.head.cells[focused].firstChild.focus();
    this.order();
  }

  order() {
    const { values, numeric } = this.columns[this.sorted.column];
    const names = this.columns[0].values;
    const sign = this.sorted.descending ? -1 : 1;
    const wanted = this.filter.toLowerCase();
    const rows = [];
    for (let i = 0; i < names.length; i++) if ((!this.only || this.only(i)) && (!wanted || names[i].toLowerCase().includes(wanted))) rows.push(i);
    const collator = new Intl.Collator("en");
    const known = (v) => v !== null && v === v;
    rows.sort((a, b) => {
      if (!numeric) return sign * collator.compare(values[a], values[b]) || a - b;
      const x = values[a], y = values[b];
      if (!known(x) || !known(y)) return Number(known(y)) - Number(known(x)) || a - b;
      return sign * (x - y) || a - b;
    });
    this.rows = rows;
    this.body.replaceChildren();
    if (rows.length) this.more();
    else this.tellNothing();
  }

  tellNothing() {
    const cell = this.body.insertRow().insertCell();
    cell.colSpan = this.columns.length;
    cell.className = "nothing";
    cell.textContent = this.filter ? `No name contains “${this.filter}”.` : "There is no target.";
  }

  more() {
    const from = this.body.rows.length;
    const part = document.createDocumentFragment();
    for (const i of this.rows.slice(from, from + this.portion)) part.append(this.row(i));
    this.body.append(part);
  }

  row(i) {
    const row = document.createElement("tr");
    row.dataset.index = String(i);
    if (i === this.chosen) row.setAttribute("aria-current", "true");
    this.columns.forEach((column, c) => {
      const cell = row.insertCell();
      if (c === 0) {
        const button = Object.assign(document.createElement("button"), { type: "button", textContent: column.text(i) });
        button.title = column.text(i);
        cell.append(button);
        return;
      }
      const value = column.values[i];
      if (column.meter && value !== null) {
        const meter = Object.assign(document.createElement("span"), { className: "meter" });
        const fill = document.createElement("i");
        fill.style.width = `${(100 * Math.min(1, value)).toFixed(1)}%`;
        meter.append(fill);
        cell.append(meter);
      }
      cell.append(column.text(i));
      if (column.flag?.(i)) cell.className = "off";
    });
    return row;
  }

  find(text) {
    this.filter = text;
    this.order();
  }

  choose(index, { scroll = true } = {}) {
    this.chosen = index;
    for (const row of this.body.rows) row.removeAttribute("aria-current");
    const place = this.rows.indexOf(index);
    if (place < 0) return;
    while (this.body.rows.length <= place) this.more();
    const row = this.body.rows[place];
    row.setAttribute("aria-current", "true");
    if (!scroll) return;
    const top = row.offsetTop - this.head.offsetHeight, bottom = row.offsetTop + row.offsetHeight;
    if (top < this.host.scrollTop || bottom > this.host.scrollTop + this.host.clientHeight) {
      this.host.scrollTop = top - this.host.clientHeight / 3;
    }
  }

  // Up and down move through the names without leaving the table.
  key(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const row = event.target.closest("tr");
    if (!step || !row) return;
    event.preventDefault();
    if (step > 0 && !row.nextElementSibling) this.more();
    const next = step > 0 ? row.nextElementSibling : row.previousElementSibling;
    if (!next) return;
    next.querySelector("button").focus();
    this.onChoose(Number(next.dataset.index));
  }
}
