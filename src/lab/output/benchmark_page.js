'use strict';
// The section of the report on benchmark.csv: how valid the scores of each method are, and what they cost.

// Metrics that the chart offers, where the file has them.
const VALIDITY = [
  ...[['test_psnr', 'by test photos'], ['val_psnr', 'by validation photos']].flatMap(([photos, by]) => [
    {metric: 'lds/' + photos, title: 'LDS', means: 'effects of training on half of the photos predicted (LDS), ' + by},
    {metric: 'lds_sizes/' + photos, title: 'LDS', means: 'effects of subsets of 40 to 100 % predicted (LDS), ' + by},
    {metric: 'sign_accuracy/' + photos, title: 'sign accuracy', means: 'helpful told from harmful photos (sign accuracy), ' + by},
    {metric: 'leave_one_out/' + photos, title: 'rho', means: 'leave-one-out predicted (Spearman’s rho), ' + by}]),
  {metric: 'removal_low/20', title: 'gain, dB', means: 'PSNR gained by leaving out the lowest 20 %'},
];
const COST = 'cost/trainings'; // in trainings on all photos

// ---- Validity against cost ----------------------------------------------------------------------------------------------

// "tmc_shapley_4N" is tmc_shapley with the budget 4N.
const familyOf = method => method.replace(/_\d*N?(\/\d+)?$/, '');

// Sorts the methods that have a cost and a value of the metric into families: [{name, points: [{x, y, low, high, name}]}], by cost.
function familiesOf(cells, methods, metric) {
  const families = new Map();
  for (const method of methods) {
    const value = cells.get(metric + ' ' + method), cost = cells.get(COST + ' ' + method);
    const x = cost ? bounded(number(cost.value)) : NaN, y = value ? bounded(number(value.value)) : NaN;
    if (!drawable(x) || !known(y)) continue;
    const name = familyOf(method), point = {x, y, low: bounded(number(value.ci_low)), high: bounded(number(value.ci_high)), name: method};
    families.set(name, [...families.get(name) || [], point]);
  }
  return [...families].map(([name, points]) => ({name, points: points.sort((a, b) => a.x - b.x)}));
}

// Makes upright lines from the lower to the upper end, with gaps between them.
const whiskersOf = points => points.filter(point => known(point.low) && known(point.high))
  .flatMap(({x, low, high}) => [{x, y: low}, {x, y: high}, {x, y: null}]);

function drawValidity(id, cells, methods, {metric, title, means}) {
  const families = familiesOf(cells, methods, metric), points = families.flatMap(family => family.points);
  if (!points.length) return clearChart(id, 'No method has a cost and this metric.');
  const level = [['noise ceiling', [9, 3, 2, 3]], ['chance', [2, 3]]].flatMap(([name, borderDash]) => {
    const cell = cells.get(metric + ' ' + name), y = cell ? bounded(number(cell.value)) : NaN;
    return known(y) ? [{label: name, data: [Math.min, Math.max].map(end => ({x: end(...points.map(point => point.x)), y})), borderDash,
      borderColor: colour('quiet'), borderWidth: 1.2, radius: 0, hitRadius: 0, pointStyle: 'line'}] : [];
  });
  drawChart(id, {
    shape: 'tall',
    label: means + ', by cost',
    caption: 'Further left is cheaper, higher is better: ' + means +
      '. A line joins the budgets of a method; upright lines are 95 % intervals.',
    behind: tableBehind('Table of validity and cost', ['method', 'trainings', title, '95 % interval'],
      () => points.map(point => [element('td', {class: 'long'}, point.name), short(point.x), fixed(point.y, 3),
        known(point.low) && known(point.high) ? fixed(point.low, 3) + ' to ' + fixed(point.high, 3) : '–']), [1, 2, 3]),
    config: () => ({type: 'scatter', data: {datasets: [
      ...families.map((family, i) => ({label: clipped(family.name), type: 'line', data: family.points, ...parameterStyle(i), radius: 4.5,
        borderWidth: 1.6, showLine: family.points.length > 1})),
      ...families.map((family, i) => ({label: 'interval', type: 'line', data: whiskersOf(family.points),
        borderColor: parameterStyle(i).borderColor, borderWidth: 0.9, radius: 0, hitRadius: 0})).filter(set => set.data.length),
      ...level.map(set => ({...set, type: 'line'}))]},
    options: {scales: {x: logAxis('cost, trainings on all photos', points.map(point => point.x)), y: axis(title, {grace: '5%'})},
      plugins: {legend: {display: true, position: 'bottom', labels: legendLabels({filter: item => item.text !== 'interval'})}, tooltip: {
        filter: item => item.raw.name !== undefined,
        callbacks: {title: () => '', label: ({raw}) => clipped(raw.name, 60) + ': ' + short(raw.x) + ' trainings, ' + fixed(raw.y, 3)}}}}}),
  });
}

// ---- The tables ---------------------------------------------------------------------------------------------------------

// Fills a row per method and a column per metric of the chosen group: "lds/val_psnr" is val_psnr of lds.
function benchmarkTable(records, group) {
  const cells = new Map(), names = [], methods = [];
  for (const row of records) {
    const [head, name = ''] = row.metric.split('/');
    if (head !== group) continue;
    if (!names.includes(name)) names.push(name);
    if (!methods.includes(row.method)) methods.push(row.method);
    cells.set(row.method + '/' + name, row);
  }
  const interval = row => row.ci_low !== '' ? ' (' + signed(number(row.ci_low), 2) + ' to ' + signed(number(row.ci_high), 2) + ')' : '';
  const place = element('div'), value = cell => cell ? number(cell.value) : NaN;
  const cellOf = name => method => cells.get(method + '/' + name), text = cell => cell ? short(value(cell)) + interval(cell) : '–';
  new SortedTable(place, [
    {title: 'Method', key: method => method, cell: method => method, class: 'long'},
    ...names.map(name => ({title: name || group, number: true, descending: true, key: method => value(cellOf(name)(method)),
      cell: method => text(cellOf(name)(method))})),
  ], {sort: null}).setRows(methods);
  return place;
}

// ---- All of it ----------------------------------------------------------------------------------------------------------

function addValidity(place, records) {
  const cells = new Map(records.map(row => [row.metric + ' ' + row.method, row])), methods = [...new Set(records.map(row => row.method))];
  const offered = VALIDITY.filter(one => familiesOf(cells, methods, one.metric).length);
  if (!offered.length) return;
  const id = 'validity-' + place, draw = metric => drawValidity(id, cells, methods, offered.find(one => one.metric === metric));
  byId('benchmarks').append(element('h3', {}, 'Validity against cost'), element('div', {class: 'filters'},
    selectBox('choose-validity-' + place, 'Validity', offered.map(one => [one.metric, one.means]), offered[0].metric, draw)),
  element('div', {id}));
  draw(offered[0].metric);
}

function fillBenchmarks() {
  byId('tradeoffs').before(element('section', {id: 'benchmarks', hidden: ''},
    element('h2', {}, 'Methods where truth is known')));
  tablesNamed('benchmark.csv').forEach((table, place) => {
    const records = recordsOf(table), groups = [...new Set(records.map(row => row.metric.split('/')[0]))];
    if (!groups.length) return;
    show('benchmarks');
    const target = element('div'), draw = group => target.replaceChildren(benchmarkTable(records, group));
    const first = groups.includes('lds') ? 'lds' : groups[0], entries = groups.map(name => [name, name]);
    byId('benchmarks').append(element('p', {class: 'quiet'}, table.label + ': metrics of benchmark.csv; intervals are 95 %.'));
    addValidity(place, records);
    byId('benchmarks').append(element('h3', {}, 'All metrics'),
      element('div', {class: 'filters'}, selectBox('choose-metric-' + place, 'Metric', entries, first, draw)), target);
    draw(first);
  });
}

fillBenchmarks();
