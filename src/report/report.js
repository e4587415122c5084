'use strict';
// The report: its data, what is chosen on the page, and its sections, from top to bottom.

const data = JSON.parse(byId('data').textContent);
const runs = data.runs;
const chosen = {run: 0, method: '', split: 'train', provider: '*', text: '', advice: '*', pair: 0, measure: 'psnr', photo: null};

// Shows credit as a share of what the training gained: the credits of hundreds of steps are not dB of a reconstruction.
function showShares({scores: {dv_psnr: credit}, steps: {first_psnr: first, last_psnr: last}}) {
  if (!credit || !(last > first)) return;
  const share = value => known(value) ? 100 * value / (last - first) : value;
  for (const key of ['value', 'ci_low', 'ci_high']) credit[key] = credit[key].map(share);
  Object.assign(credit, {ledger_unit: credit.unit, unit: '% of the gain'});
}
runs.forEach(showShares);

// Finds the folder that all names lie in, with its slash.
function folderOfAll(names) {
  let end = names.length ? names[0].lastIndexOf('/') + 1 : 0;
  for (const name of names) while (!name.startsWith(names[0].slice(0, end))) end = end > 1 ? names[0].lastIndexOf('/', end - 2) + 1 : 0;
  return names.length ? names[0].slice(0, end) : '';
}

// Photos are named without the folder that all of them lie in.
const sharedFolder = folderOfAll(runs.flatMap(one => one.images.name || []));
const withoutFolder = name => name.startsWith(sharedFolder) ? name.slice(sharedFolder.length) : name;
runs.forEach(({images}) => { if (images.name) images.name = images.name.map(withoutFolder); });

const run = () => runs[chosen.run];
const scoresOf = (one, method = chosen.method) => one.scores[method];
// Returns the method that answers for a photo's value: worth if measured, else lasting credit, else credit.
const mainMethod = one => one.advice.basis || (one.scores[data.default_method] ? data.default_method : Object.keys(one.scores)[0] || '');
const unitOf = one => (scoresOf(one) || {unit: ''}).unit;
const shortUnit = unit => ({'mean absolute error': 'MAE', '% of the gain': '%'}[unit] || unit);

// Lists the runs of the chosen run's scene: they show the same photos, so that their scores can stand side by side.
const siblings = () => runs.filter(other => other.run.scene_hash === run().run.scene_hash);

function nameOfRun(one) {
  const alike = runs.filter(other => other.run.seed === one.run.seed).length > 1;
  return alike ? one.label : 'seed ' + one.run.seed;
}

function nameOfScene(path) { return path.replace(/\/+$/, '').split('/').pop() || path; }

function thumbnailImage(uri) { return uri ? element('img', {src: uri, alt: '', loading: 'lazy', decoding: 'async'}) : null; }

function thumbnailOf(one, image) {
  return thumbnailImage(one.thumbnails === null ? null : data.thumbnail_sets[one.thumbnails][image]);
}

// Makes a text that may break after its separators.
function breakable(text) { return text.split(/(?<=[/_-])/).flatMap(part => [part, element('wbr')]); }

function nameButton(one, image) {
  const button = element('button', {type: 'button', class: 'name'}, ...breakable(one.images.name[image]));
  button.addEventListener('click', () => choosePhoto(one, image));
  return button;
}

// Makes the content of a cell: a photo with its name and facts.
function photoCell(one, image, more = []) {
  const lines = more.filter(Boolean).map(text => element('small', {}, text));
  return element('div', {class: 'photo'}, thumbnailOf(one, image), element('div', {}, nameButton(one, image), ...lines));
}

// ---- Rows of photos -----------------------------------------------------------------------------------------------------

// Returns whether ranks by a method may be shown: credit is for the validation photos, which others may contradict.
function ranksStand({verdict}, method) { return !(verdict && verdict.ranking.low) || /^(quality|worth|lasting)/.test(method); }

// Ranks all photos of the run by a method, most valuable first: rank 1 is the most valuable, and ties go by name.
function photoRows(one, method = chosen.method) {
  const {name = [], split, provider, ground_truth} = one.images, scores = scoresOf(one, method);
  const rows = name.map((text, image) => ({image, name: text, split: split[image], provider: provider[image],
    ground_truth: ground_truth[image], value: NaN, ci_low: NaN, ci_high: NaN, rank: NaN}));
  if (!scores) return rows;
  scores.image.forEach((image, i) => Object.assign(rows[image], {value: scores.value[i], ci_low: scores.ci_low[i],
    ci_high: scores.ci_high[i], visits: scores.visits[i], rankLow: scores.rank_ci_low[i], rankHigh: scores.rank_ci_high[i]}));
  const ranked = rows.filter(row => known(row.value)).sort((a, b) => b.value - a.value || (a.name < b.name ? -1 : 1));
  if (ranksStand(one, method)) ranked.forEach((row, i) => { row.rank = i + 1; });
  else ranked.forEach(row => { row.rankLow = 0; });
  return ranked.concat(rows.filter(row => !known(row.value)));
}

function valuesByName(one) {
  const scores = scoresOf(one), values = new Map();
  if (scores) scores.image.forEach((image, i) => values.set(one.images.name[image], scores.value[i]));
  return values;
}

// ---- Overview -----------------------------------------------------------------------------------------------------------

function duration(started, finished) {
  const seconds = Math.round((Date.parse(finished) - Date.parse(started)) / 1000);
  if (!Number.isFinite(seconds) || seconds < 0) return '–';
  const parts = [[Math.floor(seconds / 3600), 'h'], [Math.floor(seconds / 60) % 60, 'min'], [seconds % 60, 's']];
  const first = parts.findIndex(([count]) => count > 0);
  return first < 0 ? 'under 1 s' : parts.slice(first, first + 2).filter(([count]) => count > 0).map(part => part.join(' ')).join(' ');
}

function moment(utc) { return utc ? utc.replace('T', ' ').replace('Z', ' UTC') : '–'; }

function fillTitle() {
  const comparison = data.documents.find(one => one.kind === 'compare');
  const scenes = [...new Set(runs.map(one => nameOfScene(one.run.scene)).concat(comparison ? nameOfScene(comparison.content.scene) : []))];
  const title = scenes.length ? scenes.join(', ') : 'viewworth report';
  document.title = title + ' – viewworth';
  byId('title').textContent = title;
  byId('version').textContent = data.version;
  if (!runs.length) return;
  const counts = ['train', 'val', 'test'].map(split => run().images.split.filter(one => one === split).length);
  const {images, scene_options} = run(), weights = images.weight ?
    ' (weighted by ' + nameOfScene((scene_options || {})['val-weights'] || 'splits.json') + ')' : '';
  byId('subtitle').replaceChildren(counts[0] + ' photos to train on, ' + counts[1] + ' to validate' + weights + ', ' + counts[2] +
    ' for tests', element('span', {class: 'far'}, (runs.length > 1 ? ' · ' + plural(runs.length, 'run') : '') + ' · ' + run().run.device +
    ' · ' + moment(run().run.finished_utc)));
}

// ---- Verdict ------------------------------------------------------------------------------------------------------------

// Says how near the renders come to the validation photos, and how far the ranking can be believed.
function fillVerdict() {
  const {verdict} = run(), unknown = verdict === null || verdict.verdict === 'unknown';
  byId('verdict').hidden = byId('belief').hidden = unknown;
  if (unknown) return;
  const {reconstruction: seen, ranking} = verdict, told = [];
  if (known(ranking.better_training) && !ranking.low)
    told.push('Ranks by a training of ten times the cost would agree with these by about ' +
      fixed(ranking.better_training, 2) + '. ');
  if (known(ranking.other_views))
    told.push((ranking.low ? 'There are no ranks by credit: those' : 'Ranks') + ' by ' + ranking.views +
      ' other validation photos would agree with these by ' + fixed(ranking.other_views_low, 2) + ' to ' +
      fixed(ranking.other_views_high, 2) + ' (90 %, about ' + fixed(ranking.other_views, 2) + '). ');
  else if (ranking.low) told.push('There are no ranks by credit: so few photos cannot tell whether other validation photos would agree. ');
  byId('verdict').replaceChildren(element('b', {}, 'Reconstruction: ' + verdict.verdict + '. '),
    fixed(seen.psnr_db, 1) + ' dB and SSIM ' + fixed(seen.ssim, 2) + ', median of ' +
    plural(seen.views, seen.split === 'test' ? 'test photo' : 'validation photo') + ' at ' + seen.measured_px.join(' × ') +
    (seen.trained_px[0] === seen.measured_px[0] ? '.' : ', trained at ' + seen.trained_px.join(' × ') + '.'));
  byId('belief').replaceChildren('The mean colour of these photos has ' + fixed(seen.mean_colour_db, 1) +
    ' dB, the nearest train photo ' + fixed(seen.nearest_photo_db, 1) + '. ', ...told);
}

function tile(value, text) { return element('div', {class: 'tile'}, element('b', {}, value), element('span', {}, text)); }

// Says whether scores by the chosen method may be compared with 0.
function hasZero() { return data.methods.some(method => method.name === chosen.method && method.has_zero); }

function fillTiles() {
  const one = run(), scored = photoRows(one).filter(row => known(row.value)), {steps} = one;
  const bounded = scored.some(row => known(row.ci_low)) && !isTooCoarse(one) && ranksStand(one, chosen.method);
  const significantly = (text, test) => bounded ? text + ', ' + scored.filter(test).length + ' of them significantly' : text;
  const tiles = [tile(fixed(steps.first_psnr, 2) + ' → ' + fixed(steps.last_psnr, 2), 'dB of validation PSNR, untrained and at the end')];
  if (scored.length && hasZero()) {
    tiles.unshift(tile(String(scored.filter(row => row.value > 0).length), significantly('photos above 0', row => row.ci_low > 0)),
      tile(String(scored.filter(row => row.value < 0).length), significantly('photos below 0', row => row.ci_high < 0)));
  }
  tiles.push(tile(grouped(steps.count), 'steps in ' + plural(steps.epochs, 'epoch')),
    tile(duration(one.run.started_utc, one.run.finished_utc), 'from the first step to the end'));
  byId('tiles').replaceChildren(...tiles);
}

function warningsOf(one) {
  const {steps, matrix, images} = one, warnings = [], at = runs.length > 1 ? nameOfRun(one) + ': ' : '';
  const warn = text => warnings.push(at + text);
  if (one.run.status !== 'finished') warn('the run is ' + one.run.status + ': its scores are of the steps so far.');
  if (!Object.keys(one.scores).length) warn('there are no scores: no step counts after burn-in, or nothing was validated.');
  if (steps.nonfinite) warn(plural(steps.nonfinite, 'step') + ' of ' + grouped(steps.count) + ' were not finite and carry no value.');
  if (steps.clamped) warn(plural(steps.clamped, 'step') + ' had gradients beyond the fixed-point range, which were clamped.');
  if (steps.floored) warn('in ' + plural(steps.floored, 'step') + ' a validation photo was matched beyond 100 dB, where PSNR is cut.');
  (matrix ? matrix.view : []).forEach((image, i) => {
    const looksCorrupted = 'validation photo ' + images.name[image] + ' looks corrupted: ';
    if (matrix.disagrees[i]) warn(looksCorrupted + 'it ranks the photos as no other does, and its PSNR ends below the others’.');
    if (matrix.stays_low[i]) warn(looksCorrupted + 'its PSNR stays far below the others’.');
  });
  return warnings;
}

// Says which runs of a scene validate or test on other photos than its first.
function toldSplits() {
  const judges = split => split === 'val' || split === 'test';
  return runs.flatMap(one => {
    const first = runs.find(other => other.run.scene === one.run.scene);
    if (first === one) return [];
    const weightOf = (of, i) => of.images.weight ? of.images.weight[i] : 1, places = new Map(first.images.name.map((name, i) => [name, i]));
    const differs = one.images.name.some((name, i) => {
      const place = places.get(name), splits = [one.images.split[i], first.images.split[place]];
      return place !== undefined && splits.some(judges) && (splits[0] !== splits[1] || weightOf(one, i) !== weightOf(first, place));
    });
    return differs ? [one.label + ' validates or tests on other photos or weights than ' + first.label +
      ': their PSNR and scores cannot be compared. Value it again with --splits ' + first.label + '/splits.json.'] : [];
  });
}

function fillWarnings() {
  const warnings = runs.flatMap(warningsOf).concat(toldSplits());
  if (data.documents.some(one => one.file === 'duplicates.csv'))
    warnings.push('some photos show nearly the same: see near-duplicates before paying for them.');
  byId('warnings').replaceChildren(...warnings.map(text => element('li', {}, text)));
  byId('warnings').hidden = !warnings.length;
}

// ---- Run and method -----------------------------------------------------------------------------------------------------

// Lists the methods that a run has scores by, each with the unit of these.
function methodsOf(one) {
  return data.methods.filter(({name}) => one.scores[name]).map(method => ({...method, unit: one.scores[method.name].unit}));
}

function fillControls() {
  const method = data.methods.find(one => one.name === chosen.method);
  const boxes = [];
  if (runs.length > 1)
    boxes.push(selectBox('choose-run', 'Run', runs.map((one, i) => [i, nameOfRun(one)]), chosen.run, value => chooseRun(Number(value))));
  if (method) {
    const entries = methodsOf(run()).map(one => [one.name, one.name + ' (' + one.unit + ')']);
    boxes.push(selectBox('choose-method', 'Method', entries, chosen.method, value => { chosen.method = value; fillScored(); }));
    boxes.push(element('p', {class: 'formula quiet', id: 'formula'}, chosen.method + ': ' + method.formula +
      (/\bd\b/.test(method.formula) ? ', where d is what a step on the photo changed' : '')));
  }
  byId('controls').replaceChildren(...boxes);
  byId('controls').hidden = !boxes.length;
}

// Chooses a run, and keeps the method where that run has scores by it.
function chooseRun(place) {
  const methods = methodsOf(runs[place]).map(method => method.name);
  Object.assign(chosen, {run: place, provider: '*', text: '', advice: '*', photo: null});
  if (!methods.includes(chosen.method)) chosen.method = mainMethod(runs[place]);
  fillRun();
}

// ---- Ranking ------------------------------------------------------------------------------------------------------------

let ranking = null;

function qualitiesOf({scores: {quality}}) {
  const values = new Map();
  if (quality) quality.image.forEach((image, i) => { if (quality.visits[i]) values.set(image, quality.value[i]); });
  return values;
}

const TIERS = [['keep', 'Keep'], ['unclear', 'Cannot tell'], ['look', 'Look at'], ['drop', 'Leave out'],
  [null, 'Not trained on']]; // by the word of advice.csv
function tierOf({image}) { return run().advice.words[image]; }
function tierName(row) { return TIERS.find(([word]) => word === tierOf(row))[1]; }

function rankingColumns(rows) {
  const decimals = decimalsFor(rows.map(row => row.value)), scale = intervalScale(rows), unit = unitOf(run());
  const others = siblings().filter(one => one !== run() && scoresOf(one)).slice(0, 4);
  const qualities = chosen.method === 'quality' ? new Map() : qualitiesOf(run());
  const bar = row => intervalBar(row, scale, signed(row.value, decimals) + ' ' + unit + ', 95 % from ' + interval(row));
  const interval = row => known(row.ci_low) ? signed(row.ci_low, decimals) + ' to ' + signed(row.ci_high, decimals) : '–';
  const columns = [
    {title: 'Rank', key: row => row.rank, cell: row => known(row.rank) ? row.rank : '–', number: true, hint: '1 = highest score'},
    {title: 'Photo', key: row => row.name, class: 'long',
      cell: row => photoCell(run(), row.image, [known(row.value) && element('span', {class: 'narrow'}, bar(row)),
        row.split !== 'train' && row.split, row.provider,
        row.ground_truth && (row.ground_truth === 'clean' ? 'clean' : 'corrupted on purpose: ' + row.ground_truth)])},
    {title: 'Score, ' + shortUnit(unit), key: row => row.value, descending: true, number: true,
      hint: 'more is better (' + unit + ')',
      cell: row => element('span', {class: row.value < 0 ? 'harms' : undefined}, signed(row.value, decimals))},
    {title: '95 % interval', key: row => row.ci_low, descending: true, hint: 'of the score over seeds; sorts by its lower end',
      cell: bar, class: 'wide'},
    {title: 'from, to', cell: interval, number: true, class: others.length > 2 ? 'wide screen' : 'wide'},
    {title: 'Rank interval', key: row => row.rankLow, number: true, hint: '95 % interval of the rank', class: 'wide',
      cell: row => row.rankLow ? row.rankLow + '–' + row.rankHigh : '–'},
    ...(qualities.size ? [{title: 'Quality', key: row => qualities.get(row.image) ?? NaN, descending: true, number: true,
      hint: 'how well the photo fits: a mean of ranks, 1 fits best; not what it is worth',
      cell: row => fixed(qualities.get(row.image), 2), class: others.length ? 'wide screen' : 'wide'}] : []),
    {title: 'Tier', key: tierName, class: 'wide screen', hint: 'as the advice above has it', cell: tierName},
    {title: 'Visits', key: row => row.visits, number: true, hint: 'steps that count into the score', class: 'wide screen',
      cell: row => row.visits ?? '–'},
  ];
  for (const other of others) {
    const values = valuesByName(other);
    columns.splice(columns.length - 1, 0, {title: nameOfRun(other), number: true, class: 'wide', descending: true,
      hint: 'score in ' + other.label, key: row => values.get(row.name) ?? NaN, cell: row => signed(values.get(row.name), decimals)});
  }
  return columns;
}

function fillRankingFilters() {
  const {split, provider} = run().images, count = (list, value) => list.filter(one => one === value).length;
  const splits = ['train', 'val', 'test', 'excluded'].filter(name => count(split, name));
  const names = [...new Set(provider)].sort(collator.compare);
  const choose = what => value => { chosen[what] = value; filterRanking(); };
  const ofSplit = [['*', 'all (' + split.length + ')'], ...splits.map(name => [name, name + ' (' + count(split, name) + ')'])];
  const ofProvider = [['*', 'all'], ...names.map(name => ['=' + name, (name || 'without provider') + ' (' + count(provider, name) + ')'])];
  const boxes = [selectBox('choose-split', 'Split', ofSplit, chosen.split, choose('split'))];
  if (names.some(Boolean)) boxes.push(selectBox('choose-provider', 'Provider', ofProvider, chosen.provider, choose('provider')));
  const advised = ADVICE.map(key => [key, adviceText(run(), key), advisedPhotos(run(), key).length]).filter(([, , photos]) => photos)
    .map(([key, text, photos]) => [key, text + ' (' + photos + ')']);
  if (advised.length) boxes.push(selectBox('choose-advice', 'Advice', [['*', 'all'], ...advised], chosen.advice, choose('advice')));
  boxes.push(searchBox('choose-name', 'Name, provider or defect', choose('text')));
  byId('ranking-filters').replaceChildren(...boxes);
}

function passes(row, advised) {
  const text = [row.name, row.provider, row.ground_truth].join(' ').toLowerCase();
  return (chosen.split === '*' || row.split === chosen.split) && (chosen.provider === '*' || '=' + row.provider === chosen.provider) &&
    (chosen.advice === '*' || advised.has(row.image)) && text.includes(chosen.text.toLowerCase());
}

function filterRanking() {
  const advised = new Set(chosen.advice === '*' ? [] : advisedPhotos(run(), chosen.advice));
  ranking.table.setRows(ranking.rows.filter(row => passes(row, advised)));
}

function fillRanking() {
  const rows = photoRows(run()), columns = rankingColumns(rows);
  if (ranking) printable.splice(printable.indexOf(ranking.table), 1);
  ranking = {rows, table: new SortedTable(byId('ranking-table'), columns, {groups: TIERS, groupOf: tierOf})};
  const signs = hasZero() ? '; dots are positive, squares negative.' : '.';
  const sampled = rows.some(row => known(row.ci_low)) ? ' Bars are 95 % intervals over seeds' + signs : '';
  const told = 'By ' + chosen.method + ', in ' + unitOf(run()) + '.' + sampled + toldOverlaps(overlapsOf(rows));
  byId('ranking-note').textContent = chosen.method ? told : '';
  byId('ranking-title').textContent = ranksStand(run(), chosen.method) ? 'Photos, ranked' : 'Photos';
  filterRanking();
  show('ranking');
}

// ---- Distribution -------------------------------------------------------------------------------------------------------

// Rounds up to 1, 2 or 5 times a power of ten.
function roundUp(width) {
  const power = 10 ** Math.floor(Math.log10(width));
  return power * [1, 2, 5, 10].find(factor => factor * power >= width * (1 - 1e-9));
}

// Makes bins of equal width, one of which begins at zero.
function binsOf(values) {
  const low = Math.min(...values, 0), high = Math.max(...values, 0);
  const wanted = Math.min(40, Math.max(10, Math.ceil(2 * Math.sqrt(values.length))));
  const width = high > low ? roundUp((high - low) / wanted) : 1, first = Math.floor(low / width), bins = [];
  for (let place = first; place <= Math.floor(high / width); place++) bins.push({from: place * width, to: (place + 1) * width, count: 0});
  for (const value of values) bins[Math.min(bins.length - 1, Math.floor(value / width) - first)].count++;
  return {bins, decimals: Math.max(0, -Math.floor(Math.log10(width) + 1e-9))};
}

// Draws the hatching of negative scores, which tells them apart in grey as well.
function hatched(name) {
  const tile = document.createElement('canvas'), pen = tile.getContext('2d');
  tile.width = tile.height = 8;
  pen.fillStyle = colour(name);
  pen.fillRect(0, 0, 8, 8);
  pen.strokeStyle = colour('page');
  pen.lineWidth = 1.6;
  for (const shift of [-8, 0, 8]) { pen.moveTo(shift, 8); pen.lineTo(shift + 8, 0); }
  pen.stroke();
  return pen.createPattern(tile, 'repeat');
}

function fillDistribution() {
  const scores = scoresOf(run()), values = scores ? scores.value.filter(known) : [];
  byId('distribution').hidden = !values.length;
  if (!values.length) return;
  const {bins, decimals: digits} = binsOf(values), decimals = decimalsFor(values), unit = unitOf(run());
  const range = bin => signed(bin.from, digits) + ' to ' + signed(bin.to, digits);
  const counts = negative => bins.map(bin => bin.from < 0 === negative ? bin.count : null);
  const ordered = [...values].sort((a, b) => a - b), middle = ordered.length / 2;
  const median = (ordered[Math.ceil(middle) - 1] + ordered[Math.floor(middle)]) / 2;
  drawChart('distribution-chart', {
    label: 'Histogram of scores',
    caption: plural(values.length, 'photo') + ': median ' + signed(median, decimals) + ', mean ' + signed(mean(values), decimals) +
      ', from ' + signed(ordered[0], decimals) + ' to ' + signed(ordered[ordered.length - 1], decimals) + ' ' + unit,
    behind: tableBehind('Table of the bins', ['score, ' + unit, 'photos'], () => bins.map(bin => [range(bin), bin.count]), [1]),
    config: () => ({type: 'bar', data: {labels: bins.map(bin => signed(bin.from, digits)), datasets: [
      {label: 'negative', data: counts(true), backgroundColor: hatched('harms'), borderColor: colour('harms'), borderWidth: 1},
      {label: 'positive', data: counts(false), backgroundColor: colour('helps'), borderColor: colour('helps'), borderWidth: 1}]},
    options: {datasets: {bar: {barPercentage: 1, categoryPercentage: .96, grouped: false}},
      scales: {x: axis(chosen.method + ', ' + unit + ' (lower end of the bin)'), y: axis('photos', {beginAtZero: true,
        ticks: {precision: 0, color: colour('quiet')}})},
      plugins: {tooltip: {callbacks: {title: items => range(bins[items[0].dataIndex]) + ' ' + unit,
        label: item => plural(item.raw, 'photo')}}}}}),
  });
}

// ---- Training -----------------------------------------------------------------------------------------------------------

function fillTraining() {
  const shown = runs.filter(one => one.steps.psnr && one.steps.psnr.some(known));
  if (!shown.length) return;
  show('training');
  const points = one => one.steps.step.map((step, i) => ({x: step, y: one.steps.psnr[i]})).filter(point => known(point.y));
  const rows = () => shown.flatMap(one => one.steps.step.map((step, i) => [nameOfRun(one), grouped(step), one.steps.epoch[i] + 1,
    fixed(one.steps.psnr[i], 3), fixed(one.steps.l1[i], 5)]));
  const stride = Math.max(...shown.map(one => one.steps.stride)), last = Math.max(...shown.map(one => one.steps.count));
  drawChart('training-chart', {
    label: 'Validation PSNR over steps',
    caption: stride > 1 ? 'Every ' + stride + 'th step is shown; the ledger has all.' : 'Every step is shown.',
    behind: tableBehind('Table of the steps shown', ['run', 'step', 'epoch', 'validation PSNR, dB', 'mean absolute error'], rows,
      [1, 2, 3, 4]),
    config: () => ({type: 'line', data: {datasets: shown.map((one, i) => ({label: nameOfRun(one), data: points(one), borderWidth: 1.8,
      borderColor: PALETTE[i % PALETTE.length], borderDash: DASHES[i % DASHES.length],
      pointRadius: 0, pointHitRadius: 6}))},
    options: {parsing: false, interaction: {mode: 'nearest', axis: 'x', intersect: false},
      scales: {x: axis('step', {type: 'linear', min: 0, max: last}), y: axis('validation PSNR, dB')},
      plugins: {legend: {display: shown.length > 1, labels: legendLabels({usePointStyle: false, boxWidth: 30, boxHeight: 0})},
        tooltip: {callbacks: {title: items => 'step ' + grouped(items[0].parsed.x),
        label: item => item.dataset.label + ': ' + fixed(item.parsed.y, 3) + ' dB'}}}}}),
  });
}

// ---- Agreement of runs --------------------------------------------------------------------------------------------------

function pairsOf(list) { return list.flatMap((a, i) => list.slice(i + 1).map(b => [a, b])); }

// Lists the photos that both runs have scored by the chosen method.
function pointsOf([a, b]) {
  const inB = valuesByName(b), groundTruths = new Map(a.images.name.map((name, i) => [name, a.images.ground_truth[i]]));
  return [...valuesByName(a)].filter(([name]) => inB.has(name))
    .map(([name, value]) => ({x: value, y: inB.get(name), name,
      corrupted: Boolean(groundTruths.get(name)) && groundTruths.get(name) !== 'clean'}));
}

function agreementOf(points) {
  const a = points.map(point => point.x), b = points.map(point => point.y);
  return {r: pearson(a, b), rho: spearman(a, b)};
}

function drawScatter([a, b]) {
  const points = pointsOf([a, b]), {r, rho} = agreementOf(points), ends = points.flatMap(point => [point.x, point.y]).filter(known);
  const line = [Math.min(...ends), Math.max(...ends)].map(end => ({x: end, y: end})), decimals = decimalsFor(ends);
  const kinds = [['photos', false, 'circle', 'helps'], ['corrupted on purpose', true, 'crossRot', 'harms']];
  drawChart('agreement-chart', {
    shape: 'square',
    label: 'Scores of one run against those of another',
    caption: 'r = ' + fixed(r, 3) + ' (Pearson), rho = ' + fixed(rho, 3) + ' (Spearman), ' + plural(points.length, 'photo') + ', by ' +
      chosen.method,
    behind: tableBehind('Table of the points', ['photo', nameOfRun(a), nameOfRun(b)],
      () => points.map(point => [point.name, signed(point.x, decimals), signed(point.y, decimals)]), [1, 2]),
    config: () => ({type: 'scatter', data: {datasets: [
      ...kinds.map(([label, corrupted, pointStyle, name]) => ({label, pointStyle,
        data: points.filter(point => point.corrupted === corrupted), radius: 4.5, borderWidth: corrupted ? 2 : 1,
        borderColor: colour(name), backgroundColor: colour(name) + '99'}))
        .filter(set => set.data.length),
      {label: 'equal scores', type: 'line', data: line, borderColor: colour('quiet'), borderDash: [4, 4], borderWidth: 1, pointRadius: 0,
        pointStyle: 'line'}]},
    options: {scales: {x: axis(nameOfRun(a) + ', ' + unitOf(a), {grace: '6%'}), y: axis(nameOfRun(b) + ', ' + unitOf(b), {grace: '6%'})},
      plugins: {legend: {display: true, labels: legendLabels()}, tooltip: {
        filter: item => item.dataset.type !== 'line',
        callbacks: {label: ({raw}) => raw.name + ': ' + signed(raw.x, decimals) + ', ' + signed(raw.y, decimals)}}}}}),
  });
}

function fillAgreement() {
  const pairs = pairsOf(siblings().filter(one => scoresOf(one)));
  byId('agreement').hidden = !pairs.length;
  if (!pairs.length) return;
  const nameOfPair = ([a, b]) => nameOfRun(a) + ' and ' + nameOfRun(b);
  chosen.pair = Math.min(chosen.pair, pairs.length - 1);
  const choose = value => { chosen.pair = Number(value); drawScatter(pairs[chosen.pair]); };
  const entries = pairs.map((pair, i) => [i, nameOfPair(pair)]);
  byId('agreement-filters').replaceChildren(...pairs.length > 1 ? [selectBox('choose-pair', 'Runs', entries, chosen.pair, choose)] : []);
  drawScatter(pairs[chosen.pair]);
  const all = pairs.map(pair => agreementOf(pointsOf(pair)));
  const rows = pairs.map((pair, i) => [nameOfPair(pair), fixed(all[i].r, 3), fixed(all[i].rho, 3)]);
  if (pairs.length > 1) rows.push(['mean', fixed(mean(all.map(one => one.r)), 3), fixed(mean(all.map(one => one.rho)), 3)]);
  byId('agreement-table').replaceChildren(plainTable(['runs', 'Pearson r', 'Spearman rho'], rows, [1, 2]));
}

// ---- All of it ----------------------------------------------------------------------------------------------------------

// Draws the sections that depend on the method; fillRun those of the run, too, and fill all of them.
function fillScored() {
  fillControls();
  fillVerdict();
  fillPair();
  fillTiles();
  fillRanking();
  fillMap();
  fillPhoto();
  fillDistribution();
  fillAgreement();
  fillProviders();
}

function fillRun() {
  fillTitle();
  fillRankingFilters();
  fillPhotoChoice();
  fillScored();
  fillAdvice();
  fillScores();
  fillTrust();
  fillResiduals();
  fillMatrix();
  fillEffects();
}

function fill() {
  fillTitle();
  byId('map-views').addEventListener('keydown', stepThroughPhotos);
  if (runs.length) {
    show('overview');
    show('reading');
    chooseRun(0);
    fillTraining();
    fillRuns();
  }
  fillJobs();
  fillWarnings();
  fillDuplicates();
  fillComparisons();
  fillTradeoffs();
}
