'use strict';
// Parts of which the sections of the report are made: elements, numbers, sortable tables in pages, charts with their tables.
// Texts from the data become text nodes and attributes, never markup.

// ---- Elements -----------------------------------------------------------------------------------------------------------

// Makes an element: element('td', {class: 'number', title: '...'}, child, ...), whose children are nodes or texts.
function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) if (value !== undefined && value !== false) node.setAttribute(name, value);
  for (const child of children) if (child !== null && child !== undefined) node.append(child instanceof Node ? child : String(child));
  return node;
}

function svgElement(tag, attributes, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag); // a name: nothing is loaded
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

function byId(id) { return document.getElementById(id); }

function show(id) { byId(id).hidden = false; }

// Makes a labelled select box; entries are [value, text].
function selectBox(id, label, entries, chosen, onChange) {
  const select = element('select', {id}, ...entries.map(([value, text]) => element('option', {value}, text)));
  select.value = chosen;
  select.addEventListener('change', () => onChange(select.value));
  return element('label', {}, label, select);
}

function searchBox(id, label, onInput) {
  const input = element('input', {id, type: 'search', autocomplete: 'off'});
  input.addEventListener('input', () => onInput(input.value));
  return element('label', {}, label, input);
}

// ---- Numbers ------------------------------------------------------------------------------------------------------------

const known = value => typeof value === 'number' && Number.isFinite(value);

// Chooses two decimals, or as many as give the largest of the values three digits.
function decimalsFor(values) {
  let largest = 0;
  for (const value of values) if (known(value)) largest = Math.max(largest, Math.abs(value));
  return largest > 0 ? Math.min(8, Math.max(2, 2 - Math.floor(Math.log10(largest)))) : 2;
}

function fixed(value, decimals) {
  if (!known(value)) return '–';
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? '−' + text : text;
}

function signed(value, decimals) {
  const text = fixed(value, decimals);
  return known(value) && value > 0 && Number(text) !== 0 ? '+' + text : text;
}

function grouped(count) { return String(count).replace(/\B(?=(\d{3})+(?!\d))/g, '\u202f'); }

function short(value) { return known(value) ? String(Number(value.toPrecision(4))).replace('-', '−') : '–'; }

function plural(count, noun) { return grouped(count) + ' ' + noun + (count === 1 ? '' : 's'); }

function mean(values) { return values.length ? values.reduce((sum, value) => sum + value, 0) / values.length : NaN; }

// Averages the known values.
function weightedMean(values, weights) {
  const places = values.map((_, i) => i).filter(i => known(values[i])), sum = of => places.reduce((total, i) => total + of(i), 0);
  return places.length ? sum(i => weights[i] * values[i]) / sum(i => weights[i]) : NaN;
}

// Computes Pearson's correlation of the pairs of which both are known.
function pearson(a, b) {
  const places = a.map((_, i) => i).filter(i => known(a[i]) && known(b[i]));
  const meanA = mean(places.map(i => a[i])), meanB = mean(places.map(i => b[i]));
  let ab = 0, aa = 0, bb = 0;
  for (const i of places) {
    ab += (a[i] - meanA) * (b[i] - meanB);
    aa += (a[i] - meanA) ** 2;
    bb += (b[i] - meanB) ** 2;
  }
  return aa > 0 && bb > 0 ? ab / Math.sqrt(aa * bb) : NaN;
}

// Ranks values from 1 for the smallest; equal values share the mean of their ranks.
function ranksOf(values) {
  const order = values.map((_, i) => i).sort((a, b) => values[a] - values[b]), ranks = [];
  for (let first = 0; first < order.length;) {
    let end = first;
    while (end < order.length && values[order[end]] === values[order[first]]) end++;
    for (let i = first; i < end; i++) ranks[order[i]] = (first + end + 1) / 2;
    first = end;
  }
  return ranks;
}

function spearman(a, b) {
  const places = a.map((_, i) => i).filter(i => known(a[i]) && known(b[i]));
  return pearson(ranksOf(places.map(i => a[i])), ranksOf(places.map(i => b[i])));
}

// ---- Tables -------------------------------------------------------------------------------------------------------------

const printable = []; // tables that show more rows on paper than in a page of the screen
const PAGE_ROWS = 50, PRINTED_ROWS = 200;

const collator = new Intl.Collator(undefined, {numeric: true}); // photo_2 before photo_10

function compareKeys(a, b) {
  const lastA = a === null || a === undefined || Number.isNaN(a), lastB = b === null || b === undefined || Number.isNaN(b);
  if (lastA || lastB) return lastA && lastB ? 0 : lastA ? Infinity : -Infinity; // unknown at the end, whichever way
  return typeof a === 'string' ? collator.compare(a, b) : a - b;
}

// Makes a table that is sorted by clicking its headers, shown page by page. A column is {title, key: row -> number or text to sort by,
// cell:
// row -> text or node, or a td of its own, number: true to align right, class, hint, descending: true where the first click puts the
// largest first}. `sort` is the column to begin with; null: the order given.
// `groups`: [[value, heading], ...] of groupOf(row), under which rows stand while the first column sorts them from its smallest up.
class SortedTable {
  constructor(place, columns, {sort = 0, descending = false, pageRows = PAGE_ROWS, heat = false, groups = [], groupOf} = {}) {
    Object.assign(this, {columns, sort, descending, pageRows, heat, groups, groupOf, page: 0, rows: []});
    this.head = element('tr');
    this.body = element('tbody');
    this.pager = element('div', {class: 'pager'});
    this.table = element('table', {}, element('thead', {}, this.head), this.body);
    place.replaceChildren(element('div', {class: heat ? 'scroll heat' : 'scroll'}, this.table), this.pager);
    this.fillHead();
    printable.push(this);
  }

  fillHead() {
    this.head.replaceChildren(...this.columns.map((column, place) => {
      const cell = element('th', {scope: 'col', class: this.classOf(column), title: column.hint}, column.key ? '' : column.title);
      if (!column.key) return cell;
      if (place === this.sort) cell.setAttribute('aria-sort', this.descending ? 'descending' : 'ascending');
      const button = element('button', {type: 'button'}, column.title);
      button.addEventListener('click', () => this.sortBy(place));
      cell.append(button);
      return cell;
    }));
  }

  classOf(column) { return [column.number ? 'number' : '', column.class || ''].join(' ').trim() || undefined; }

  sortBy(place) {
    this.descending = place === this.sort ? !this.descending : Boolean(this.columns[place].descending);
    this.sort = place;
    this.page = 0;
    this.fillHead();
    this.update();
  }

  setRows(rows) {
    this.rows = rows;
    this.page = 0;
    this.update();
  }

  // Stable, so that equal keys keep the order in which the rows were given.
  sorted() {
    const {key} = this.columns[this.sort] || {}, sign = this.descending ? -1 : 1;
    if (!key) return this.rows;
    const rows = this.rows.map(row => [key(row), row])
      .sort(([a], [b]) => { const order = compareKeys(a, b); return Number.isFinite(order) ? sign * order : Math.sign(order); })
      .map(([, row]) => row);
    return this.isGrouped() ? this.groups.flatMap(([value]) => rows.filter(row => this.groupOf(row) === value)) : rows;
  }

  isGrouped() { return this.groups.length > 0 && this.sort === 0 && !this.descending; }

  // Makes the row of a group's heading; nothing where the group of the row before goes on.
  headingOf(row, before) {
    const value = this.groupOf(row);
    if (before && this.groupOf(before) === value) return [];
    const count = this.rows.filter(other => this.groupOf(other) === value).length;
    const cell = element('th', {scope: 'rowgroup', colspan: this.columns.length}, this.groups.find(([of]) => of === value)[1],
      element('span', {class: 'quiet'}, ' ' + grouped(count)));
    return [element('tr', {class: 'group'}, cell)];
  }

  cellOf(column, row) {
    const content = column.cell(row);
    return content instanceof HTMLTableCellElement ? content : element('td', {class: this.classOf(column)}, content);
  }

  update() {
    const rows = this.sorted(), pages = Math.max(1, Math.ceil(rows.length / this.pageRows));
    this.page = Math.min(this.page, pages - 1);
    const first = this.page * this.pageRows, shown = rows.slice(first, first + this.pageRows);
    this.body.replaceChildren(...shown.flatMap((row, i) => [...this.isGrouped() ? this.headingOf(row, shown[i - 1]) : [],
      element('tr', {}, ...this.columns.map(column => this.cellOf(column, row)))]));
    this.fillPager(first, shown.length, rows.length, pages);
  }

  fillPager(first, shown, count, pages) {
    if (!count) return this.pager.replaceChildren('Nothing fits the filters.');
    if (pages === 1) return this.pager.replaceChildren();
    const turn = (text, page) => {
      const button = element('button', {type: 'button'}, text);
      button.disabled = page < 0 || page >= pages;
      button.addEventListener('click', () => { this.page = page; this.update(); });
      return button;
    };
    this.pager.replaceChildren(turn('‹ Back', this.page - 1), turn('Next ›', this.page + 1),
      'rows ' + grouped(first + 1) + ' to ' + grouped(first + shown) + ' of ' + grouped(count));
  }
}

// Makes a table of texts that is shown whole, without sorting. Rows are arrays of texts or nodes; `numbers` are the columns to align right.
function plainTable(header, rows, numbers = []) {
  const kind = place => numbers.includes(place) ? 'number' : undefined;
  return element('div', {class: 'scroll'}, element('table', {},
    element('thead', {}, element('tr', {}, ...header.map((title, i) => element('th', {scope: 'col', class: kind(i)}, title)))),
    element('tbody', {}, ...rows.map(row => element('tr', {}, ...row.map((cell, i) =>
      cell instanceof HTMLTableCellElement ? cell : element('td', {class: kind(i)}, cell)))))));
}

// Makes the table of a chart, when it is opened.
function tableBehind(title, header, makeRows, numbers) {
  const details = element('details', {}, element('summary', {}, title));
  details.addEventListener('toggle', () => {
    if (details.open && details.children.length === 1) details.append(plainTable(header, makeRows(), numbers));
  });
  return details;
}

// ---- Intervals ----------------------------------------------------------------------------------------------------------

// Makes the scale that intervals share: it spans zero and nearly all of their ends. One far outlier would squeeze all others to a dot:
// what lies
// beyond is drawn up to an arrow at the edge.
function intervalScale(rows) {
  const ends = rows.flatMap(row => [row.value, row.ci_low, row.ci_high]).filter(known).sort((a, b) => a - b);
  const place = share => ends[Math.round(share * (ends.length - 1))];
  const low = Math.min(0, ends.length ? place(.02) : 0), high = Math.max(0, ends.length ? place(.98) : 0);
  return high > low ? {low, high} : {low: -1, high: 1};
}

// Draws a dot (positive) or a square (negative) with its error bar around it, and zero dashed. `harms` is given where less is better.
function intervalBar({value, ci_low: low, ci_high: high, harms = value < 0}, scale, title) {
  const at = end => Math.min(154, Math.max(6, 6 + 148 * (end - scale.low) / (scale.high - scale.low)));
  const kind = harms ? 'harms' : 'helps', ends = known(low) && known(high) ? [low, high] : [value, value];
  const bar = svgElement('svg', {class: 'interval', viewBox: '0 0 160 18', role: 'img', 'aria-label': title},
    svgElement('title', {}, title), svgElement('line', {class: 'zero', x1: at(0), x2: at(0), y1: 0, y2: 18}));
  if (!known(value)) return bar;
  bar.append(svgElement('line', {class: kind + ' whisker', x1: at(ends[0]), x2: at(ends[1]), y1: 9, y2: 9}));
  if (ends[0] < scale.low) bar.append(svgElement('path', {class: kind, d: 'M7 5 L1 9 L7 13 Z'}));
  if (ends[1] > scale.high) bar.append(svgElement('path', {class: kind, d: 'M153 5 L159 9 L153 13 Z'}));
  bar.append(harms ? svgElement('rect', {class: kind, x: at(value) - 3.5, y: 5.5, width: 7, height: 7})
    : svgElement('circle', {class: kind, cx: at(value), cy: 9, r: 4}));
  return bar;
}

// ---- Charts -------------------------------------------------------------------------------------------------------------

const PALETTE = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#7f7f7f']; // Okabe and Ito
const DASHES = [[], [7, 4], [2, 3], [9, 3, 2, 3], [12, 4], [4, 4], [1, 2]]; // told apart in grey as well
const POINTS = ['circle', 'rect', 'triangle', 'rectRot', 'cross', 'star', 'crossRot'];
const PAPER = {ink: '#1b1f24', quiet: '#59636e', line: '#d9dee3', page: '#ffffff', helps: '#0072b2', harms: '#c65102'};
const PAPER_WIDTH_PX = 680, HEAT_COLUMN_PX = 44;
const PAPER_CHARTS_PX = { // width, height
  '': [PAPER_WIDTH_PX, 260], square: [420, 420], tall: [PAPER_WIDTH_PX, 460], small: [225, 200], map: [330, 330],
};
const charts = new Map(); // by the place they are drawn in
let onPaper = false;

// Sections far down are drawn when they come near the screen, or are printed.
const pending = new Map(); // by the section's id
const watcher = new IntersectionObserver(entries => entries.filter(entry => entry.isIntersecting)
  .forEach(entry => drawNow(entry.target.id)), {rootMargin: '400px'});

function whenSeen(id, draw) {
  pending.set(id, draw);
  watcher.observe(byId(id));
}

function drawNow(id) {
  const draw = pending.get(id);
  watcher.unobserve(byId(id));
  pending.delete(id);
  if (draw) draw();
}

function drawPending() { [...pending.keys()].forEach(drawNow); }

function colour(name) {
  return onPaper ? PAPER[name] : getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
}

function axis(title, more = {}) {
  return {title: {display: true, text: title, color: colour('ink')}, grid: {color: colour('line')},
    ticks: {color: colour('quiet'), maxRotation: 0, autoSkipPadding: 14}, ...more};
}

function legendLabels(more = {}) { return {color: colour('ink'), usePointStyle: true, boxWidth: 8, boxHeight: 8, ...more}; }

// Draws into a place, in place of what was drawn there before: {config, caption, label, shape, behind}; `config` is a function, so that a
// chart can be drawn anew in other colours, and `shape` 'square', 'tall' for many series, or 'small' for one beside others.
function drawChart(id, {config, caption, label, shape = '', behind}) {
  const before = charts.get(id);
  if (before) before.chart.destroy();
  const canvas = element('canvas', {role: 'img', 'aria-label': label});
  byId(id).replaceChildren(element('figure', {}, element('div', {class: ('chart ' + shape).trim()}, canvas),
    caption ? element('figcaption', {}, caption) : null), ...(behind ? [behind] : []));
  const settings = config();
  settings.options = {animation: false, responsive: !onPaper, maintainAspectRatio: false, ...settings.options};
  settings.options.plugins = {legend: {display: settings.data.datasets.length > 1, labels: legendLabels()}, ...settings.options.plugins};
  if (onPaper) {
    [canvas.width, canvas.height] = PAPER_CHARTS_PX[shape];
    settings.options.devicePixelRatio = 2;
  }
  charts.set(id, {chart: new Chart(canvas, settings), drawing: {config, caption, label, shape, behind}});
}

function redrawCharts() { for (const [id, {drawing}] of [...charts]) drawChart(id, drawing); }

// On paper tables go on beyond their page, and charts and the matrix fit its width.
window.addEventListener('beforeprint', () => {
  drawPending();
  onPaper = true;
  for (const table of printable) {
    table.screenRows = table.pageRows;
    if (table.rows.length <= PRINTED_ROWS) table.pageRows = PRINTED_ROWS;
    if (table.heat) table.table.style.zoom = Math.min(1, PAPER_WIDTH_PX / (HEAT_COLUMN_PX * (table.columns.length + 2)));
    table.update();
  }
  redrawCharts();
});
window.addEventListener('afterprint', () => {
  onPaper = false;
  for (const table of printable) {
    table.pageRows = table.screenRows || table.pageRows;
    table.table.style.zoom = '';
    table.update();
  }
  redrawCharts();
});
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redrawCharts);
