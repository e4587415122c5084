'use strict';
// The section of the report on tradeoff.csv: the time of a run at each configuration, beside its PSNR and the quality of its scores.

const TRADEOFF_NUMBERS = ['train_ms', 'value_ms', 'scoring_ratio', 'run_seconds', 'val_psnr', 'seed_pearson',
  'agreement_pearson'];
const TRADEOFF_MEASURES = [
  {key: 'agreement_pearson', title: 'agreement r', digits: 3, means: 'agreement with the full_resolution scores (Pearson’s r)'},
  {key: 'seed_pearson', title: 'seeds r', digits: 3, means: 'agreement of two seeds (Pearson’s r)'},
];
const LONGEST_NAME = 24; // characters of a name in a chart: tables and tooltips have more

const clipped = (text, length = LONGEST_NAME) => text.length > length ? text.slice(0, length - 1) + '…' : text;

// Turns a number that no axis can show into an unknown one: an edited file may hold any.
const bounded = value => Math.abs(value) < 1e9 ? value : NaN;
const drawable = value => value > 1e-6 && value < 1e9;

function timeOf(seconds) {
  if (!drawable(seconds)) return '–';
  const [count, unit] = seconds < 120 ? [seconds, 's'] : seconds < 7200 ? [seconds / 60, 'min'] : [seconds / 3600, 'h'];
  return (count < 10 ? Number(count.toPrecision(2)) : Math.round(count)) + ' ' + unit;
}

// ---- Configurations and methods -------------------------------------------------------------------------------------------------

// Sorts rows by configuration and method: {rows, methods, configurations}, where configurations are the first rows of each, in the
// order of the
// file.
function tradeoffOf(table) {
  const rows = recordsOf(table).map(row => ({...row, base: row.base === '1', psnr_pareto_front: row.psnr_pareto_front === '1',
    ...Object.fromEntries(TRADEOFF_NUMBERS.map(name => [name, bounded(number(row[name]))]))}));
  const configurations = new Map();
  for (const row of rows) if (!configurations.has(row.configuration)) configurations.set(row.configuration, row);
  return {rows, methods: [...new Set(rows.map(row => row.method).filter(Boolean))],
    configurations: [...configurations.values()]};
}

// Returns a row per configuration: that of the method, or, when it has none, the columns that do not depend on the method.
function rowsOfMethod({rows, configurations}, method) {
  const scored = new Map(rows.filter(row => row.method === method).map(row => [row.configuration, row]));
  const none = Object.fromEntries(TRADEOFF_MEASURES.map(one => [one.key, NaN]));
  return configurations.map(row => scored.get(row.configuration) || {...row, ...none});
}

function tradeoffSummary({configurations, methods}) {
  const times = configurations.map(row => row.run_seconds).filter(drawable), base = configurations.find(row => row.base);
  const range = [...new Set([Math.min(...times), Math.max(...times)].map(timeOf))].join(' to ');
  return plural(configurations.length, 'configuration') + ', ' + plural(methods.length, 'method') +
    (times.length ? '; a run takes ' + range : '') +
    (base ? '. The base takes ' + timeOf(base.run_seconds) + ' and reaches ' + fixed(base.val_psnr, 2) + ' dB' : '') + '.';
}

// ---- Axes ---------------------------------------------------------------------------------------------------------------

// Chooses the ticks of a logarithmic axis: 1, 2 and 5 times powers of ten, powers alone over many, finer steps within less than one.
function logTicks(low, high) {
  const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high)), stride = Math.ceil((last - first) / 8);
  const between = factors => {
    const ticks = [];
    for (let power = first; power <= last; power += stride) ticks.push(...factors.map(factor => factor * 10 ** power));
    return ticks.filter(tick => tick >= low && tick <= high);
  };
  const coarse = between(stride > 1 || last - first > 4 ? [1] : [1, 2, 5]);
  if (coarse.length > 2) return coarse;
  const step = roundUp((high - low) / 5), ticks = [];
  for (let tick = Math.ceil(low / step) * step; tick <= high; tick += step) ticks.push(Number(tick.toPrecision(6)));
  return ticks;
}

// Makes a logarithmic axis around the values, which are positive.
function logAxis(title, values) {
  const low = Math.min(...values) / 1.15, high = Math.max(...values) * 1.15;
  return axis(title, {type: 'logarithmic', min: low, max: high,
    afterBuildTicks: scale => { scale.ticks = logTicks(low, high).map(value => ({value})); },
    ticks: {color: colour('quiet'), maxRotation: 0, autoSkipPadding: 14, callback: value => short(value)}});
}

// ---- Time against quality -----------------------------------------------------------------------------------------------

// Returns the colour and shape of a parameter, which only together are its own: there are more parameters than colours.
function parameterStyle(place) {
  const shape = POINTS[(place + Math.floor(place / PALETTE.length)) % POINTS.length], tint = PALETTE[place % PALETTE.length];
  return {pointStyle: shape, borderColor: tint, backgroundColor: tint, radius: 5, hoverRadius: 7,
    borderWidth: /cross|star/.test(shape) ? 2 : 1};
}

// Draws configurations over their time, by the column `key`. With `front`, a line joins the Pareto front. `about` begins the caption.
function drawCost({id, rows, key, title, digits, front = false, about = ''}) {
  const shown = rows.filter(row => drawable(row.run_seconds) && known(row[key]));
  if (!shown.length) return clearChart(id, 'No configuration has a value of ' + title + ' by this method.');
  const points = list => list.map(row => ({x: row.run_seconds, y: row[key], name: row.configuration}));
  const parameters = [...new Set(rows.filter(row => !row.base).map(row => row.parameter))];
  const joined = front ? shown.filter(row => row.psnr_pareto_front).sort((a, b) => a.run_seconds - b.run_seconds) : [];
  const line = joined.length > 1 ? points(joined) : [];
  drawChart(id, {
    shape: 'square',
    label: 'Seconds of a run against ' + title,
    caption: about + 'Further left is faster, higher is better; the ring is the base.' +
      (joined.length > 1 ? ' The line is the Pareto front: no other configuration is as good in less time.' : ''),
    behind: tableBehind('Table of the configurations', ['configuration', 'seconds of a run', title],
      () => shown.map(row => [element('td', {class: 'long'}, row.configuration), short(row.run_seconds), fixed(row[key], digits)]), [1, 2]),
    config: () => ({type: 'scatter', data: {datasets: [
      {label: 'base', data: points(shown.filter(row => row.base)), pointStyle: 'circle', radius: 7, hoverRadius: 9, borderWidth: 3,
        borderColor: colour('ink'), backgroundColor: 'transparent'},
      ...parameters.map((parameter, i) => ({label: clipped(parameter), ...parameterStyle(i),
        data: points(shown.filter(row => !row.base && row.parameter === parameter))})),
      {label: 'Pareto front', type: 'line', data: line, borderColor: colour('quiet'), borderWidth: 1.5,
        radius: 0, hitRadius: 0, pointStyle: 'line'}].filter(set => set.data.length)},
    options: {scales: {x: logAxis('seconds of a run', shown.map(row => row.run_seconds)), y: axis(title, {grace: '6%'})},
      plugins: {legend: {display: true, position: 'bottom', labels: legendLabels()}, tooltip: {
        filter: item => item.dataset.type !== 'line',
        callbacks: {label: ({raw}) => clipped(raw.name, 60) + ': ' + short(raw.x) + ' s, ' + fixed(raw.y, digits)}}}}}),
  });
}

// ---- One parameter -----------------------------------------------------------------------------------------------------------

function parametersOf({configurations}) {
  const values = new Map();
  for (const {parameter, value, base} of configurations)
    if (!base) values.set(parameter, (values.get(parameter) || new Set()).add(value));
  return [...values.keys()].filter(parameter => values.get(parameter).size > 1);
}

// Places values on an axis: numbers by their logarithm, then words ("all"), a step apart.
function placesOf(values) {
  const numbers = values.filter(text => drawable(number(text))).sort((a, b) => number(a) - number(b));
  const ends = numbers.map(text => Math.log10(number(text))), span = ends.length > 1 ? ends[ends.length - 1] - ends[0] : 0;
  const step = span > 0 ? span / (ends.length - 1) : 1, places = new Map(numbers.map((text, i) => [text, ends[i]]));
  let last = ends.length ? ends[ends.length - 1] : 0;
  for (const text of values) if (!places.has(text)) places.set(text, last += step);
  return {places, step, isScale: numbers.length > 1};
}

function valueAxis(parameter, {places, step}) {
  const ticks = [...places].map(([text, value]) => ({value, label: clipped(text, 12)})).sort((a, b) => a.value - b.value);
  const labels = new Map(ticks.map(tick => [tick.value, tick.label])), characters = ticks.reduce((sum, tick) => sum + tick.label.length, 0);
  return axis(clipped(parameter), {type: 'linear', min: ticks[0].value - step / 3, max: ticks[ticks.length - 1].value + step / 3,
    afterBuildTicks: scale => { scale.ticks = ticks.map(({value}) => ({value})); },
    ticks: {color: colour('quiet'), minRotation: characters > (onPaper ? 12 : 24) ? 40 : 0, maxRotation: 50, autoSkipPadding: 4,
      callback: value => labels.get(value) ?? ''}});
}

// Returns the base's value of a parameter, from its list of all: "rays 500, samples 32, ...". '' where the list lacks it.
function valueOfBase(base, parameter) {
  const part = base.value.split(', ').find(text => text.startsWith(parameter + ' '));
  return part ? part.slice(parameter.length + 1) : '';
}

// Draws the values of a parameter against one column, with the base as a dashed line.
function drawParameter({id, rows, parameter, key, title, digits, log = false, caption}) {
  const fits = row => log ? drawable(row[key]) : known(row[key]);
  const base = rows.find(row => row.base), own = base ? valueOfBase(base, parameter) : '';
  const ofParameter = [...rows.filter(row => row.parameter === parameter && !row.base), ...own ? [{...base, value: own}] : []];
  const shown = ofParameter.filter(fits);
  if (!shown.some(row => !row.base)) return clearChart(id, 'No value of ' + clipped(parameter) + ' has ' + title + '.');
  const scale = placesOf([...new Set(ofParameter.map(row => row.value))]), ends = [...scale.places.values()];
  const points = column => ofParameter.filter(row => known(row[column]))
    .map(row => ({x: scale.places.get(row.value), y: row[column], value: row.value})).sort((a, b) => a.x - b.x);
  const level = base && fits(base) ? [Math.min(...ends) - scale.step / 3, Math.max(...ends) + scale.step / 3]
    .map(x => ({x, y: base[key], value: 'base'})) : [];
  const heights = [...shown, ...level.length ? [base] : []].map(row => row[key]);
  const lineOf = name => ({borderColor: colour(name), backgroundColor: colour(name), borderWidth: 1.8, radius: 4, showLine: scale.isScale});
  drawChart(id, {
    shape: 'small',
    label: title + ' by the value of ' + clipped(parameter),
    caption,
    behind: tableBehind('Table of the values', ['value', title],
      () => ofParameter.map(row => [element('td', {class: 'long'}, row.value), fixed(row[key], digits)]), [1]),
    config: () => ({type: 'line', data: {datasets: [
      {label: title, data: points(key), ...lineOf('helps')},
      {label: 'base', data: level, borderColor: colour('quiet'), borderDash: [4, 4], borderWidth: 1.5, radius: 0, hitRadius: 0,
        pointStyle: 'line'}].filter(set => set.data.length)},
    options: {scales: {x: valueAxis(parameter, scale), y: log ? logAxis(title, heights) : axis(title, {grace: '8%'})},
      plugins: {legend: {display: false}, tooltip: {
        filter: item => item.raw.value !== undefined,
        callbacks: {title: () => '', label: ({raw}) => clipped(raw.value, 60) + ': ' + fixed(raw.y, digits)}}}}}),
  });
}

// ---- The table ----------------------------------------------------------------------------------------------------------

function tradeoffTable(place) {
  const metric = (title, key, digits, more = {}) =>
    ({title, key: row => row[key], cell: row => fixed(row[key], digits), number: true, descending: true, ...more});
  return new SortedTable(place, [
    {title: 'Configuration', key: row => row.configuration, class: 'long',
      cell: row => row.base ? element('b', {}, row.configuration) : row.configuration},
    {title: 'Run, s', key: row => row.run_seconds, number: true, hint: 'seconds, with scoring', cell: row => fixed(row.run_seconds, 1)},
    metric('Step, ms', 'value_ms', 2, {descending: false, class: 'wide', hint: 'a training step with its scoring'}),
    metric('Ratio', 'scoring_ratio', 2, {descending: false, class: 'wide', hint: 'step with scoring / without'}),
    metric('PSNR, dB', 'val_psnr', 2, {hint: 'of validation photos; none where other pixels are measured'}),
    metric('Seeds r', 'seed_pearson', 3, {class: 'wide', hint: 'Pearson’s correlation of the scores of two seeds'}),
    metric('Agrees r', 'agreement_pearson', 3, {hint: 'Pearson’s correlation with the full_resolution scores'}),
    {title: 'Pareto front', key: row => row.psnr_pareto_front ? 1 : 0, number: true, descending: true, class: 'wide',
      cell: row => row.psnr_pareto_front ? 'yes' : '–', hint: 'no other configuration reaches as high a PSNR in less time'},
  ], {sort: 1});
}

// ---- All of it ----------------------------------------------------------------------------------------------------------

function clearChart(id, text) {
  const before = charts.get(id);
  if (before) before.chart.destroy();
  charts.delete(id);
  byId(id).replaceChildren(element('p', {class: 'quiet'}, text));
}

function drawTradeoff(one) {
  const rows = rowsOfMethod(one.tradeoff, one.method), measure = TRADEOFF_MEASURES.find(({key}) => key === one.measure);
  const method = clipped(one.method, 40);
  one.table.setRows(rows);
  drawCost({id: one.id + '-psnr', rows, key: 'val_psnr', title: 'validation PSNR, dB', digits: 2, front: true});
  if (measure)
    drawCost({id: one.id + '-score', rows, ...measure, about: 'By ' + method + ': ' + measure.means + '. '});
  if (!one.parameter) return;
  const draw = (name, more) => drawParameter({id: one.id + '-' + name, rows, parameter: one.parameter, digits: 2, ...more});
  if (measure)
    draw('parameter-score', {...measure, caption: 'By ' + method + ': where the line is flat, a cheaper value does as well.'});
  draw('parameter-psnr', {key: 'val_psnr', title: 'validation PSNR, dB', caption: 'How quality depends on the parameter.'});
  draw('parameter-time', {key: 'run_seconds', title: 'seconds of a run', log: true,
    caption: 'How the time of a run depends on it; dashed is the base.'});
}

function addTradeoff(table, place) {
  const tradeoff = tradeoffOf(table), {methods} = tradeoff, parameters = parametersOf(tradeoff), id = 'tradeoff-' + place;
  if (!tradeoff.configurations.length) return;
  show('tradeoffs');
  const measures = TRADEOFF_MEASURES.filter(({key}) => tradeoff.rows.some(row => known(row[key])));
  const summary = tradeoffSummary(tradeoff), leads = !runs.length && !place; // this section comes first
  const one = {id, tradeoff, parameter: parameters[0], measure: measures.length ? measures[0].key : '',
    method: methods.includes(data.default_method) ? data.default_method : methods[0] || ''};
  const choice = (name, title, entries) => entries.length > 1 ? [selectBox(id + '-choose-' + name, title, entries, one[name],
    value => { one[name] = value; drawTradeoff(one); })] : [];
  const spot = name => element('div', {id: id + '-' + name}), target = element('div', {id: id + '-table'});
  byId('tradeoffs').append(
    element('p', {class: 'quiet'}, table.label + ': each configuration is the base with one parameter changed. ' + (leads ? '' : summary)),
    element('div', {class: 'filters'}, ...choice('method', 'Method', methods.map(name => [name, name])),
      ...choice('measure', 'Measure of the scores', measures.map(({key, means}) => [key, means]))),
    element('div', {class: 'beside'}, spot('psnr'), spot('score')));
  if (parameters.length)
    byId('tradeoffs').append(element('h3', {}, 'One parameter at a time'),
      element('div', {class: 'filters'}, ...choice('parameter', 'Parameter', parameters.map(name => [name, clipped(name)]))),
      element('div', {class: 'beside three'}, spot('parameter-score'), spot('parameter-psnr'), spot('parameter-time')));
  byId('tradeoffs').append(element('h3', {}, 'Configurations'), target);
  one.table = tradeoffTable(target);
  drawTradeoff(one);
  if (leads) byId('subtitle').textContent = summary;
}

function fillTradeoffs() { tablesNamed('tradeoff.csv').forEach(addTradeoff); }
