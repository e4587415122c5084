'use strict';
// The sections of the report that are tables: jobs, providers, near-duplicates, the matrix, effects, runs and comparisons.

// ---- CSV files of the folder --------------------------------------------------------------------------------------------

const number = text => text === '' || text === undefined ? NaN : Number(text);

// Returns the rows of a CSV file as objects with its header as keys.
function recordsOf({content: {header, rows}}) {
  return rows.map(row => Object.fromEntries(header.map((name, i) => [name, row[i] ?? ''])));
}

function tablesNamed(file) { return data.documents.filter(one => one.kind === 'table' && one.file === file); }

// ---- The jobs of a batch ------------------------------------------------------------------------------------------------

// Makes a link only of paths that batch itself writes: the table may be a stranger's.
function reportLink(path) {
  return /^[\w-]+(\/[\w-]+)*\/report\.html$/.test(path) ? element('a', {href: path}, 'report') : '';
}

function fillJobs() {
  for (const table of tablesNamed('summary.csv')) {
    const rows = recordsOf(table), failed = rows.filter(row => row.message !== '').length, place = element('div');
    show('jobs');
    byId('jobs').append(element('p', {class: 'quiet'}, table.label + ': ' + plural(rows.length, 'job') +
      (failed ? ', ' + grouped(failed) + ' failed' : '') + '; validation PSNR after the last step.'), place);
    const count = key => ({key: row => number(row[key]), cell: row => row[key] || '–', number: true});
    new SortedTable(place, [
      {title: 'Job', key: row => row.job, cell: row => row.job, class: 'long'},
      {title: 'State', key: row => row.state, cell: row => row.state},
      {title: 'Photos', ...count('photos')},
      {title: 'Steps', ...count('steps')},
      {title: 'Seconds', ...count('seconds')},
      {title: 'PSNR, dB', key: row => number(row.val_psnr), cell: row => fixed(number(row.val_psnr), 2), number: true, descending: true},
      {title: '', cell: row => row.message || reportLink(row.report), class: 'long'},
    ], {sort: null}).setRows(rows);
  }
}

// ---- Providers ----------------------------------------------------------------------------------------------------------

let providersTable = null;

function fillProviders() {
  const table = tablesNamed('providers.csv').find(one => one.label === run().label);
  const payouts = tablesNamed('payout.csv').find(one => one.label === run().label);
  byId('providers').hidden = !table;
  if (!table) return;
  const rows = recordsOf(table).filter(row => row.method === chosen.method).map(row => ({...row, value: number(row.value),
    error: number(row.stderr), photos: number(row.photos), rank: number(row.rank)}));
  for (const row of rows) Object.assign(row, {ci_low: row.value - 1.96 * row.error, ci_high: row.value + 1.96 * row.error});
  const paid = payouts ? recordsOf(payouts) : [], decimals = decimalsFor(rows.map(row => row.value)), scale = intervalScale(rows);
  const shown = 'Sums of their photos’ scores by ' + chosen.method + '; bars are the sum ± 1.96 standard errors.';
  byId('providers-note').textContent = (rows.length ? shown : chosen.method + ' does not add up over photos: choose another method.') +
    (paid.length ? ' Each photo is paid by its worth where that is positive, a provider the sum over its photos [90 % interval].' : '');
  const sum = row => signed(row.value, decimals), payout = row => paid.find(one => one.provider === row.provider);
  const columns = [
    {title: 'Provider', key: row => row.provider, cell: row => row.provider || 'without provider', class: 'long'},
    {title: 'Photos', key: row => row.photos, cell: row => row.photos, number: true},
    {title: 'Sum, ' + shortUnit((scoresOf(run()) || {}).ledger_unit || unitOf(run())), key: row => row.value, descending: true,
      number: true,
      cell: row => element('span', {class: row.value < 0 ? 'harms' : undefined}, sum(row))},
    {title: 'Interval', cell: row => intervalBar(row, scale, sum(row)), class: 'wide'},
    {title: '± standard error', cell: row => fixed(row.error, decimals), number: true, class: 'wide'},
  ];
  if (paid.length)
    columns.push({title: 'Payout', number: true, class: 'long',
      cell: row => payout(row) ? payout(row).amount +
        (payout(row).ci_low ? ' [' + payout(row).ci_low + ', ' + payout(row).ci_high + ']' : '') : '–'});
  if (providersTable) printable.splice(printable.indexOf(providersTable), 1);
  providersTable = new SortedTable(byId('providers-table'), columns, {sort: null});
  providersTable.setRows(rows);
}

// ---- Near-duplicates ----------------------------------------------------------------------------------------------------

function fillDuplicates() {
  const tables = tablesNamed('duplicates.csv');
  if (!tables.length) return;
  show('duplicates');
  const rows = tables.flatMap(table => recordsOf(table).map(row => ({...row, name: withoutFolder(row.name),
    one: runs.find(one => one.label === table.label)})));
  const decimals = decimalsFor(rows.map(row => number(row.value)));
  const imageOf = row => row.one ? row.one.images.name.indexOf(row.name) : -1;
  const table = new SortedTable(byId('duplicates-table'), [
    {title: 'Group', key: row => number(row.group), cell: row => number(row.group) + 1, number: true},
    {title: 'Photo', key: row => row.name, class: 'long', cell: row => imageOf(row) < 0 ? row.name : photoCell(row.one, imageOf(row))},
    {title: 'Provider', key: row => row.provider, cell: row => row.provider || '–', class: 'long'},
    {title: 'Split', key: row => row.split, cell: row => row.split},
    {title: 'Similarity', key: row => number(row.similarity), cell: row => fixed(number(row.similarity), 4), number: true, class: 'wide'},
    {title: 'Score', key: row => number(row.value), cell: row => signed(number(row.value), decimals), number: true,
      hint: rows[0] && rows[0].method},
    {title: 'Group’s score', cell: row => signed(number(row.group_value), decimals), number: true, class: 'wide'},
  ]);
  table.setRows(rows);
}

// ---- The matrix ---------------------------------------------------------------------------------------------------------

const HELPS_RGB = [0, 114, 178], HARMS_RGB = [213, 94, 0];

// Colours a cell from white to full colour, with text that can be read on either.
function heatCell(value, largest, text, hint) {
  const cell = element('td', {class: 'number', title: hint}, text);
  const strength = known(value) ? Math.min(1, Math.abs(value) / largest) : 0, full = value < 0 ? HARMS_RGB : HELPS_RGB;
  const rgb = full.map(part => Math.round(255 + (part - 255) * strength));
  cell.style.backgroundColor = 'rgb(' + rgb.join(',') + ')';
  cell.style.color = .3 * rgb[0] + .59 * rgb[1] + .11 * rgb[2] < 130 ? '#ffffff' : '#1b1f24';
  return cell;
}

// Returns the value that has full colour, the 98th percentile: beside one outlier most cells would be white.
function fullColour(values) {
  const sizes = values.flat().filter(known).map(Math.abs).sort((a, b) => a - b);
  return sizes.length ? sizes[Math.floor(.98 * (sizes.length - 1))] || sizes[sizes.length - 1] || 1 : 1;
}

let matrixTables = [];

function matrixColumns(one, rows, unit) {
  const {matrix, images} = one, values = matrix[chosen.measure], largest = fullColour(values), decimals = decimalsFor([largest]);
  const meanOf = row => weightedMean(values[row], matrix.view.map(view => images.weight ? images.weight[view] : 1));
  return [
    {title: 'Photo', key: row => images.name[matrix.photo[row]], class: 'photo-name',
      cell: row => photoCell(one, matrix.photo[row])},
    {title: 'Mean', key: meanOf, descending: true, number: true, hint: 'over the validation photos',
      cell: row => signed(meanOf(row), decimals)},
    ...matrix.view.map((view, place) => ({title: images.name[view], key: row => values[row][place], descending: true, class: 'view',
      hint: 'validation photo ' + images.name[view] + ', ends at ' + fixed(matrix.end_psnr[place], 2) + ' dB; sort by it',
      cell: row => heatCell(values[row][place], largest, signed(values[row][place], decimals), images.name[matrix.photo[row]] + ' for ' +
        images.name[view] + ': ' + signed(values[row][place], decimals + 2) + ' ' + unit)})),
  ];
}

function fillMatrix() {
  const one = run(), {matrix} = one;
  byId('matrix').hidden = !matrix;
  for (const table of matrixTables) printable.splice(printable.indexOf(table), 1);
  matrixTables = [];
  if (!matrix) return;
  const unit = chosen.measure === 'psnr' ? 'dB' : 'mean absolute error removed';
  byId('matrix-note').textContent = 'A row per photo, a column per validation photo: what the photo’s steps changed there, in ' + unit +
    '. Blue and positive is better, orange and negative worse; full colour from ±' + short(fullColour(matrix[chosen.measure])) + ' on.';
  const measures = [['psnr', 'PSNR, dB'], ['l1', 'mean absolute error removed']];
  byId('matrix-filters').replaceChildren(selectBox('choose-measure', 'Measure', measures, chosen.measure,
    value => { chosen.measure = value; fillMatrix(); }));
  const rows = matrix.photo.map((_, row) => row);
  const heat = new SortedTable(byId('matrix-table'), matrixColumns(one, rows, unit), {sort: 1, descending: true, heat: true});
  heat.setRows(rows);
  matrixTables = [heat, viewsTable(one)];
}

function viewsTable(one) {
  const {matrix, images} = one;
  const verdict = i => [matrix.disagrees[i] && 'ranks as no other does', matrix.stays_low[i] && 'stays far below the others',
    matrix.lone[i] && 'no: sees what no other does, keep it']
    .filter(Boolean);
  const table = new SortedTable(byId('views-table'), [
    {title: 'Validation photo', key: i => images.name[matrix.view[i]], class: 'long', cell: i => photoCell(one, matrix.view[i])},
    ...(images.weight ? [{title: 'Weight', key: i => images.weight[matrix.view[i]], cell: i => short(images.weight[matrix.view[i]]),
      number: true, hint: 'in validation PSNR and L1, and so in the scores'}] : []),
    {title: 'PSNR at the end, dB', key: i => matrix.end_psnr[i], cell: i => fixed(matrix.end_psnr[i], 2), number: true},
    {title: 'Agreement', key: i => matrix.agreement[i], cell: i => fixed(matrix.agreement[i], 2), number: true,
      hint: 'Spearman’s correlation of its column with the mean of the others'},
    {title: 'Ranking without it', key: i => matrix.without[i], cell: i => fixed(matrix.without[i], 3), number: true,
      hint: 'Spearman’s correlation of the ranking without it to the one with it', class: 'wide'},
    {title: 'Looks corrupted', key: i => verdict(i).length, descending: true, cell: i => verdict(i).join('; ') || 'no'},
  ], {pageRows: 25});
  table.setRows(matrix.view.map((_, i) => i));
  return table;
}

// ---- Effects and runs ---------------------------------------------------------------------------------------------------

function fillEffects() {
  const effects = Array.isArray(run().effects) ? run().effects : [];
  byId('effects').hidden = !effects.length;
  const word = flag => flag ? 'yes' : 'no';
  const known = value => typeof value === 'number';
  const found = one => short(one.evidence) + (known(one.evidence_stderr) ? ' ± ' + short(one.evidence_stderr) : '');
  const rows = effects.map(one => [one.name, word(one.on), word(one.called_for), found(one), short(one.threshold),
    short(one.ms_per_step), known(one.device_bytes) ? grouped(one.device_bytes) : '–',
    element('td', {class: 'long'}, [one.meaning, one.measured_on].filter(Boolean).join('; '))]);
  const header = ['effect', 'simulated', 'called for', 'evidence', 'threshold', 'ms per step', 'bytes', 'which is'];
  byId('effects-table').replaceChildren(plainTable(header, rows, [3, 4, 5, 6]));
}

function textOf(value) { return value !== null && typeof value === 'object' ? JSON.stringify(value) : String(value ?? '–'); }

function fillRuns() {
  show('runs');
  const facts = [
    ['folder', one => one.label], ['scene', one => one.run.scene], ['status', one => one.run.status], ['seed', one => one.run.seed],
    ['started', one => moment(one.run.started_utc)], ['ended', one => moment(one.run.finished_utc)],
    ['took', one => duration(one.run.started_utc, one.run.finished_utc)], ['steps', one => grouped(one.steps.count)],
    ['validation PSNR at the end', one => fixed(one.steps.last_psnr, 3) + ' dB'], ['device', one => one.run.device],
    ['driver', one => one.run.driver], ['viewworth', one => one.run.version], ['run_id', one => one.run.run_id],
    ['hash of the scene', one => one.run.scene_hash], ['hash of the photos trained on', one => one.run.subset_hash],
    ['hash of the shaders', one => one.run.shader_hash], ['head of the ledger', one => one.run.head],
  ];
  const chosen = {accuracy: 'accuracy level', budget_s: '--budget, s', trade_off: 'trade-off'};
  for (const [key, title] of Object.entries(chosen))
    if (runs.some(one => (one.plan || {})[key] !== undefined)) facts.push([title, one => textOf((one.plan || {})[key])]);
  const row = ([title, value]) => [element('th', {scope: 'row'}, title), ...runs.map(one =>
    element('td', {class: /hash|run_id|head/.test(title) ? 'hash' : 'long'}, value(one)))];
  byId('runs-table').replaceChildren(plainTable(['', ...runs.map(nameOfRun)], facts.map(row)));
  const keys = list => [...new Set(list.flatMap(one => Object.keys(one || {})))].sort();
  const options = keys(runs.map(one => one.scene_options)).map(key => ['scene option ' + key, one => textOf(one.scene_options[key])]);
  const settings = keys(runs.map(one => one.config)).map(key => [key, one => textOf(one.config[key])]);
  byId('config-table').replaceChildren(tableBehind('Configuration', ['setting', ...runs.map(nameOfRun)],
    () => [...settings, ...options].map(row), []));
}

// ---- Comparisons --------------------------------------------------------------------------------------------------------

const MEASURES = [['psnr', 'PSNR, dB', 2], ['ssim', 'SSIM', 4], ['l1', 'L1', 5]];
const measureName = name => {
  const [split, measure] = name.split('_'), known = MEASURES.find(one => one[0] === measure);
  return (split === 'val' ? 'validation' : split) + ' ' + (known ? known[1] : measure);
};
const measureDigits = name => (MEASURES.find(one => one[0] === name.split('_')[1]) || [0, 0, 4])[2];

// Lists the measures that some list has. PSNR on the test photos comes first: it alone was neither trained on nor used to select.
function measuresOf(compare) {
  return ['test', 'val'].flatMap(split => MEASURES.map(([measure]) => split + '_' + measure))
    .filter(name => compare.lists.some(list => known((list.mean || {})[name])));
}

// Folds the other measures.
function folded(title, ...nodes) { return nodes.length ? element('details', {}, element('summary', {}, title), ...nodes) : null; }

function listsTable(compare, names) {
  const value = (list, kind, name) => fixed((list[kind] || {})[name], measureDigits(name));
  const cell = (list, name) => known((list.mean || {})[name]) ? value(list, 'mean', name) + ' ± ' + value(list, 'stderr', name) : '–';
  const counts = list => [...new Set((list.outcomes || []).map(one => one.photo_count))].join(' / ');
  const rows = compare.lists.map(list => [element('td', {class: 'long'}, list.name), counts(list), ...names.map(name => cell(list, name))]);
  return plainTable(['list', 'photos', ...names.map(measureName)], rows, [1, ...names.map((_, i) => i + 2)]);
}

// Draws seeds as points and their mean as a bar.
function drawLists(id, compare, name) {
  const lists = compare.lists.filter(list => known((list.mean || {})[name])), digits = measureDigits(name);
  const pointsOfList = list => list.outcomes.filter(one => known(one[name])).map(one => ({x: list.name, y: one[name], seed: one.seed}));
  const seeds = lists.flatMap(pointsOfList);
  const ends = seeds.map(point => point.y), margin = (Math.max(...ends) - Math.min(...ends)) / 4 || .1;
  if (!lists.length) return;
  drawChart(id, {
    label: measureName(name) + ' by list of photos',
    caption: 'Bars are means over seeds, points the seeds. The axis does not begin at zero.',
    behind: tableBehind('Table of the points', ['list', 'seed', measureName(name)],
      () => seeds.map(point => [point.x, point.seed, fixed(point.y, digits)]), [1, 2]),
    config: () => ({type: 'bar', data: {labels: lists.map(list => list.name), datasets: [
      {type: 'scatter', label: 'seeds', data: seeds, pointStyle: 'rectRot', radius: 5, backgroundColor: colour('harms'),
        borderColor: colour('page')},
      {label: 'mean', data: lists.map(list => list.mean[name]), backgroundColor: colour('helps') + 'aa', borderColor: colour('helps'),
        borderWidth: 1, maxBarThickness: 70}]},
    options: {scales: {x: axis('list', {type: 'category'}), y: axis(measureName(name), {min: Math.min(...ends) - margin, grace: '5%'})},
      plugins: {tooltip: {callbacks: {label: item => (item.raw.seed === undefined ? 'mean' : 'seed ' + item.raw.seed) + ': ' +
        fixed(item.parsed.y, digits)}}}}}),
  });
}

// L1: lower is better.
const isWorse = pair => known(pair.difference) && pair.difference !== 0 && pair.difference < 0 !== pair.measure.endsWith('_l1');

function verdictOf(pair) {
  if (!known(pair.ci_low)) return 'a single seed says nothing of noise';
  return pair.beyond_noise ? isWorse(pair) ? 'worse' : 'better' : 'within noise';
}

function pairsTable(compare, pairs) {
  const digits = pair => measureDigits(pair.measure);
  const bar = pair => intervalBar({value: pair.difference, ci_low: pair.ci_low, ci_high: pair.ci_high, harms: isWorse(pair)},
    intervalScale(compare.pairs.filter(one => one.measure === pair.measure).map(one => ({...one, value: one.difference}))),
    signed(pair.difference, digits(pair)) + ', ' + verdictOf(pair));
  const place = element('div');
  const table = new SortedTable(place, [
    {title: 'List', key: pair => pair.list, cell: pair => pair.list, class: 'long'},
    {title: 'against', key: pair => pair.against, cell: pair => pair.against, class: 'long'},
    {title: 'Measure', key: pair => pair.measure, cell: pair => measureName(pair.measure)},
    {title: 'Difference', key: pair => pair.difference, descending: true, number: true,
      cell: pair => signed(pair.difference, digits(pair))},
    {title: '95 % interval', cell: bar, class: 'wide'},
    {title: 'from, to', number: true, cell: pair => signed(pair.ci_low, digits(pair)) + ' to ' + signed(pair.ci_high, digits(pair))},
    {title: 'Verdict', key: verdictOf, cell: verdictOf, hint: 'of L1 less is better, of the others more'},
  ], {sort: null});
  table.setRows(pairs);
  return place;
}

// Makes the table of photos that lists differ in. A photo's picture is the run's, where the page has a run of the scene, or else one
// of the document's own.
function disagreementsTable(compare, thumbnails) {
  const place = element('div'), one = runs.find(other => other.run.scene_hash === compare.scene_hash && other.thumbnails !== null);
  const imageOf = row => one ? one.images.name.indexOf(withoutFolder(row.photo)) : -1;
  const uriOf = row => Object.hasOwn(thumbnails, row.photo) ? thumbnails[row.photo] : null;
  const ownCell = row => element('div', {class: 'photo'}, thumbnailImage(uriOf(row)), element('div', {}, row.photo));
  new SortedTable(place, [
    {title: 'Photo', key: row => row.photo, class: 'long', cell: row => imageOf(row) < 0 ? ownCell(row) : photoCell(one, imageOf(row))},
    {title: 'in', key: row => row.in.join(', '), cell: row => row.in.join(', '), class: 'long'},
    {title: 'not in', key: row => row.not_in.join(', '), cell: row => row.not_in.join(', '), class: 'long'},
  ]).setRows(compare.disagreements);
  return place;
}

function renderFigure(render, pictures) {
  const uri = pictures[render.file];
  return element('figure', {}, element('div', {class: 'captions'}, ...(render.columns || []).map(text => element('span', {}, text))),
    uri ? element('img', {src: uri, alt: 'renders of ' + render.view, loading: 'lazy'}) : null,
    element('figcaption', {}, render.view + ' (' + render.split + ')'));
}

const HALF_VIEWS = ' Appearance is taken from the left half of each photo: all figures are of the right halves.';

function fillComparison({content: compare, pictures, thumbnails, label}, place) {
  const [first, ...others] = measuresOf(compare), isFirst = pair => pair.measure === first;
  const shown = compare.pairs.filter(isFirst), hidden = compare.pairs.filter(pair => !isFirst(pair));
  const id = 'comparison-chart-' + place, parts = (list, make, title) => list && list.length ? [element('h3', {}, title), make()] : [];
  byId('comparisons').append(
    element('p', {class: 'quiet'}, label + ': ' + nameOfScene(compare.scene) + ', seeds ' + (compare.seeds || []).join(', ') + ', ' +
      plural(compare.epochs, 'epoch') + (compare.downscale > 1 ? ', photos divided by ' + compare.downscale : '') +
      '. Mean ± standard error over seeds; every list is trained anew with the same seeds.' + (compare.half_views ? HALF_VIEWS : '')),
    listsTable(compare, first ? [first] : []), element('div', {id}),
    ...parts(shown, () => pairsTable(compare, shown), 'Paired differences'),
    folded('Other measures', ...(others.length ? [listsTable(compare, others)] : []),
      ...(hidden.length ? [pairsTable(compare, hidden)] : [])) || '',
    ...parts(compare.disagreements, () => disagreementsTable(compare, thumbnails), 'Photos on which lists disagree'),
    ...parts(compare.renders, () => element('div', {class: 'renders'}, ...compare.renders.map(render => renderFigure(render, pictures))),
      'Renders side by side'));
  drawLists(id, compare, first || 'val_psnr');
}

function fillComparisons() {
  data.documents.filter(one => one.kind === 'compare').forEach((one, place) => {
    show('comparisons');
    try {
      fillComparison(one, place);
    } catch (error) { // somebody edited the file
      byId('comparisons').append(element('p', {}, one.label + '/compare.json cannot be shown (' + error.message + '): compare again.'));
    }
  });
}

fill();
