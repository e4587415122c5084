'use strict';
// The sections on advice, on photos that cannot be told apart, and on credit beside lasting credit beside worth.

const WORDS = {dv_psnr: 'credit', lasting_psnr: 'lasting credit', worth_psnr: 'worth'};
function wordFor(method) { return WORDS[method] ? WORDS[method] + ' (' + method + ')' : method; }

// ---- Photos that cannot be told apart -----------------------------------------------------------------------------------

// Counts the values of a sorted list that lie below a value.
function countBelow(sorted, value) {
  let low = 0, high = sorted.length;
  while (low < high) { const middle = (low + high) >> 1; if (sorted[middle] < value) low = middle + 1; else high = middle; }
  return low;
}

// Counts for each photo how many intervals of other photos overlap its own.
function overlapsOf(rows) {
  const bounded = rows.filter(row => known(row.ci_low) && known(row.ci_high));
  const sorted = key => bounded.map(row => row[key]).sort((a, b) => a - b);
  const lows = sorted('ci_low'), highs = sorted('ci_high');
  const after = value => value + Math.abs(value) * Number.EPSILON + Number.MIN_VALUE; // intervals that touch overlap
  return new Map(bounded.map(row => [row.image, countBelow(lows, after(row.ci_high)) - countBelow(highs, row.ci_low) - 1]));
}

// Makes a sentence on how many pairs of photos cannot be told apart.
function toldOverlaps(overlaps) {
  const count = overlaps.size, pairs = count * (count - 1) / 2;
  if (!pairs) return '';
  const alike = [...overlaps.values()].reduce((sum, one) => sum + one, 0) / 2;
  return alike >= pairs ? ' All ' + grouped(count) + ' photos are indistinguishable by it: their intervals overlap.' :
    ' Photos whose intervals overlap are indistinguishable: ' + (100 * alike / pairs).toFixed(0) + ' % of the pairs.';
}

// ---- Advice -------------------------------------------------------------------------------------------------------------

const ADVICE = ['removable', 'irreplaceable', 'look', 'lone'];
const OF_CREDIT = {look: 'needs a look', lone: 'lone view'};

// Says whether the retrainings of a run with a gate confirm what lasting credit predicts.
function passesGate({gate}) { return known(gate.correlation) && gate.correlation >= gate.least; }

// Says whether the gate refutes the advice; it tests lasting credit alone.
function isRefuted(one) { return one.advice.basis === 'lasting_psnr' && one.gate !== null && !passesGate(one); }

// Says whether no retraining has shown yet that worth tells photos apart here: then nothing is said of leaving photos out.
function isUnshown(one) { return one.advice.basis === 'worth_psnr' && !one.advice.tested; }

// Says whether the reconstruction is too coarse to rank photos by.
function isTooCoarse(one) { return one.verdict !== null && one.verdict.verdict.startsWith('too coarse'); }

function advisedPhotos(one, key) { return !OF_CREDIT[key] && (isRefuted(one) || isUnshown(one)) ? [] : one.advice[key]; }

function adviceText(one, key) {
  return OF_CREDIT[key] || (one.advice.by_order ? 'probably ' : key === 'removable' ? 'safely ' : '') + key;
}

function adviceOf(one, image) {
  return ADVICE.filter(key => advisedPhotos(one, key).includes(image)).map(key => adviceText(one, key)).join(', ');
}

// Says how well worth, or a score of its prior, predicts retrainings that it does not know.
function accuracyOf({accuracy}, i) {
  return fixed(accuracy.spearman[i], 2) + ' (' + fixed(accuracy.ci_low[i], 2) + ' to ' + fixed(accuracy.ci_high[i], 2) + ')';
}

function toldAccuracy(one) {
  const {accuracy} = one;
  if (!accuracy) return one.retrainings ? 'Too few retrainings tell how far worth can be trusted here.' : '';
  const others = accuracy.method.slice(1).map((name, i) => wordFor(name) + ' ' + accuracyOf(one, i + 1));
  return 'Accuracy of worth on left-out retrainings, beyond the number of photos: ' + accuracyOf(one, 0) +
    ', Spearman with its 95 % interval, of ' + plural(accuracy.retrainings, 'retraining') + '. ' +
    (others.length ? 'Of the scores of its prior: ' + others.join(', ') + '. ' : '') +
    (known(accuracy.noise_db) ? 'Trainings on all photos differ by ' + fixed(accuracy.noise_db, 3) +
      ' dB between seeds: no score can exceed about ' + fixed(accuracy.ceiling, 2) + '.' : '');
}

function whyAdvised(one) {
  const {basis, by_order: byOrder} = one.advice;
  const looks = ' A look is advised at photos with a defect, and at those that fit badly and have low credit.';
  if (isTooCoarse(one)) return ' The reconstruction is too coarse to say which photos can be left out: train longer, for example by' +
    ' --accuracy reference.' + looks;
  if (isRefuted(one)) return ' The gate says that lasting credit is not to be trusted here:' +
    ' which photos can be left out is not said.' + looks;
  if (isUnshown(one)) return ' The retrainings do not show that worth tells photos apart here' +
    (one.accuracy ? ' (accuracy ' + accuracyOf(one, 0) + ')' : '') + ': which photos can be left out is not said.' + looks;
  if (!basis) return looks + ' Which photos can be left out, credit does not say: ' + (one.config.field === 'splats' ?
    'worth does (viewworth worth).' : 'lasting credit or worth does (viewworth lasting, viewworth worth).');
  if (byOrder) return ' This rests on the order by ' + wordFor(basis) +
    ', which no retraining of this scene has tested: take out one photo at a time.' + looks;
  return ' This rests on the 95 % intervals of ' + wordFor(basis) + ', from retrainings of this scene' +
    (one.accuracy ? ' (accuracy ' + accuracyOf(one, 0) + ')' : '') +
    '. Without one of the removable photos, a training loses less than another seed changes: take out one photo at a time.' + looks;
}

const TOLD = [['keep', 'Keep'], ['look', 'Look at'], ['drop', 'Leave out'], ['unclear', 'Cannot tell']];
const ROW_PHOTOS = 12;

// Lists the photos that are told the same, the most telling first: the best to keep, elsewhere the worst.
function toldPhotos(one, word) {
  const rows = photoRows(one, mainMethod(one)).filter(row => one.advice.words[row.image] === word);
  return word === 'keep' ? rows : rows.reverse();
}

function tellingPhoto(one, row) {
  const name = one.images.name[row.image];
  const reason = [one.advice.reasons[row.image], one.advice.texts[row.image]].filter(Boolean).join(': ');
  const picture = thumbnailOf(one, row.image);
  const button = element('button', {type: 'button', class: 'telling', title: name, 'aria-label': name + ': ' + reason},
    picture, element('span', {class: picture ? 'name' : 'bare'}, name), element('span', {}, reason));
  button.addEventListener('click', () => choosePhoto(one, row.image));
  return button;
}

// Draws a row of photos for each word of advice; that of photos to leave out only where there are some.
function fillAdvised(one) {
  byId('advised').replaceChildren(...TOLD.map(([word, title]) => [word, title, toldPhotos(one, word)])
    .filter(([word, , rows]) => rows.length || word !== 'drop')
    .map(([word, title, rows]) => element('div', {class: 'advised', 'data-word': word},
      element('h2', {}, title, element('span', {class: 'quiet'}, ' ' + grouped(rows.length))),
      element('div', {class: 'strip'}, ...rows.slice(0, ROW_PHOTOS).map(row => tellingPhoto(one, row)),
        rows.length ? null : element('p', {class: 'quiet'}, 'none'),
        rows.length > ROW_PHOTOS ? element('p', {class: 'quiet'}, grouped(rows.length - ROW_PHOTOS) + ' more in the ranking') : null))));
}

function fillAdvice() {
  const one = run(), shown = Object.keys(one.scores).length > 0;
  byId('advice').hidden = byId('advised').hidden = !shown;
  if (!shown) return;
  fillAdvised(one);
  byId('advice').replaceChildren(element('span', {class: 'quiet'}, whyAdvised(one).trim()));
}

// ---- Credit beside lasting credit beside worth --------------------------------------------------------------------------

let scoresTable = null;

function drawScores(one, x, y) {
  const rows = [x, y].map(method => new Map(photoRows(one, method).filter(row => known(row.value)).map(row => [row.image, row])));
  const {name, ground_truth: truth} = one.images;
  const points = [...rows[0]].filter(([image]) => rows[1].has(image)).map(([image, row]) => ({x: row.value,
    y: rows[1].get(image).value, image, corrupted: Boolean(truth[image]) && truth[image] !== 'clean'}));
  const decimals = [points.map(point => point.x), points.map(point => point.y)].map(decimalsFor);
  const kinds = [['photos', false, 'circle', 'helps'], ['corrupted on purpose', true, 'crossRot', 'harms']].map(
    ([label, corrupted, pointStyle, of]) => ({label, pointStyle, of, data: points.filter(point => point.corrupted === corrupted)}))
    .filter(set => set.data.length);
  drawChart('scores-chart', {shape: 'square', label: wordFor(y) + ' against ' + wordFor(x),
    caption: 'rho = ' + fixed(spearman(points.map(point => point.x), points.map(point => point.y)), 3) + ' (Spearman), ' +
      plural(points.length, 'photo') + '. Click a point to see its photo.',
    config: () => ({type: 'scatter', data: {datasets:
      kinds.map(set => ({label: set.label, pointStyle: set.pointStyle, data: set.data, radius: 4.5,
        borderColor: colour(set.of), backgroundColor: colour(set.of) + '99'}))},
    options: {scales: {x: axis(wordFor(x) + ', ' + shortUnit(one.scores[x].unit), {grace: '6%'}),
      y: axis(wordFor(y) + ', ' + shortUnit(one.scores[y].unit), {grace: '6%'})},
      onClick: (event, items) => {
        const item = items.find(other => other.datasetIndex < kinds.length);
        if (item) choosePhoto(run(), kinds[item.datasetIndex].data[item.index].image);
      },
      plugins: {legend: {display: kinds.length > 1, labels: legendLabels()}, tooltip: {
        callbacks: {label: ({raw}) => name[raw.image] + ': ' + signed(raw.x, decimals[0]) + ', ' + signed(raw.y, decimals[1])}}}}}),
  });
}

function fillScoresTable(one, methods) {
  const tables = new Map(methods.map(({name}) => [name, photoRows(one, name)])), images = tables.get(methods[0].name).map(row => row.image);
  const rowOf = new Map(methods.map(({name}) => [name, new Map(tables.get(name).map(row => [row.image, row]))]));
  if (scoresTable) printable.splice(printable.indexOf(scoresTable), 1);
  const cell = (name, image) => {
    const row = rowOf.get(name).get(image), decimals = decimalsFor(tables.get(name).map(other => other.value));
    const told = known(row.ci_low) ? signed(row.ci_low, decimals) + ' to ' + signed(row.ci_high, decimals) : '';
    return element('span', {}, signed(row.value, decimals), told ? element('small', {class: 'quiet wide'}, ' ' + told) : null);
  };
  scoresTable = new SortedTable(byId('scores-table'), [
    {title: 'Photo', key: image => one.images.name[image], class: 'long', cell: image => photoCell(one, image, [adviceOf(one, image)])},
    ...methods.map(({name, unit: of}) => ({title: (WORDS[name] || name) + ', ' + shortUnit(of), number: true, descending: true,
      hint: name + ', with its 95 % interval', key: image => rowOf.get(name).get(image).value, cell: image => cell(name, image)})),
  ], {sort: null, pageRows: 25});
  scoresTable.setRows(images.filter(image => methods.some(({name}) => known(rowOf.get(name).get(image).value))));
}

// Draws the table of credits, where there is more than one kind.
function fillScores() {
  const one = run(), shown = ['worth_psnr', 'lasting_psnr'].filter(name => one.scores[name]);
  byId('scores').hidden = !shown.length;
  if (!shown.length) return;
  byId('accuracy-note').textContent = toldAccuracy(one);
  const methods = methodsOf(one), entries = methods.map(({name}) => [name, wordFor(name)]), picked = {x: 'dv_psnr', y: shown[0]};
  if (!one.scores[picked.x]) picked.x = methods[0].name;
  const box = (key, label) => selectBox('choose-scores-' + key, label, entries, picked[key], value => {
    picked[key] = value;
    drawScores(one, picked.x, picked.y);
  });
  byId('scores-filters').replaceChildren(box('x', 'Across'), box('y', 'Up'));
  const listed = ['worth_psnr', 'lasting_psnr', 'dv_psnr', 'quality'].filter(name => methods.some(method => method.name === name));
  whenSeen('scores', () => {
    drawScores(one, picked.x, picked.y);
    fillScoresTable(one, listed.map(name => methods.find(method => method.name === name)));
  });
}

// ---- Predicted against measured -----------------------------------------------------------------------------------------

function emptyChart(id) {
  if (charts.has(id)) charts.get(id).chart.destroy();
  charts.delete(id);
  byId(id).replaceChildren();
}

// Draws points {x, y, label} and the line of equality, or that of least squares where x and y are in different units.
function drawPredicted(id, {points, line, label, across, up, caption}) {
  const decimals = decimalsFor(points.flatMap(point => [point.x, point.y]));
  drawChart(id, {shape: 'square', label, caption,
    behind: tableBehind('Table of the points', ['', across, up],
      () => points.map(point => [point.label, signed(point.x, decimals), signed(point.y, decimals)]), [1, 2]),
    config: () => ({type: 'scatter', data: {datasets: [
      {label: 'measured', data: points, radius: 4.5, borderColor: colour('helps'), backgroundColor: colour('helps') + '99'},
      {...line, type: 'line', borderColor: colour('quiet'), borderDash: [4, 4], borderWidth: 1, pointRadius: 0, pointStyle: 'line'}]},
    options: {scales: {x: axis(across, {grace: '6%'}), y: axis(up, {grace: '6%'})},
      plugins: {legend: {display: true, labels: legendLabels()}, tooltip: {filter: item => item.dataset.type !== 'line',
        callbacks: {label: ({raw}) => raw.label + ': ' + signed(raw.x, decimals) + ', ' + signed(raw.y, decimals)}}}}}),
  });
}

function correlations(points) {
  const x = points.map(point => point.x), y = points.map(point => point.y);
  return {r: pearson(x, y), rho: spearman(x, y)};
}

function gatePoints({gate, images}) {
  return (gate ? gate.image : []).map((image, i) => ({x: gate.predicted[i], y: gate.measured[i], label: images.name[image] ?? '–'}))
    .filter(point => known(point.x) && known(point.y));
}

function drawGate(one) {
  const points = gatePoints(one), ends = points.flatMap(point => [point.x, point.y]);
  if (!points.length) return emptyChart('gate-chart');
  return drawPredicted('gate-chart', {points, label: 'The gate: predicted against measured change',
    line: {label: 'equality', data: [Math.min(...ends), Math.max(...ends)].map(end => ({x: end, y: end}))},
    across: 'predicted by lasting credit, dB', up: 'measured by retraining, dB',
    caption: 'The gate: steps on a photo were made longer. r = ' + fixed(one.gate.correlation, 2) + ' over ' +
      plural(points.length, 'photo') + '.'});
}

function drawGrowth({growth}) {
  const points = growth ? growth.step.map((step, i) => ({x: step, y: growth.size[i]})).filter(point => point.y > 0) : [];
  if (!points.length) return emptyChart('growth-chart');
  return drawChart('growth-chart', {shape: 'square', label: 'Horizon: size of the gradient that is carried backwards, by step',
    caption: 'The horizon, read from right to left: the size of the gradient of the final PSNR behind each step. A fall to the left says ' +
      'that later steps forget; a steep rise says that lasting credit of early steps is not to be trusted.',
    behind: tableBehind('Table of the curve', ['step', 'size'], () => points.map(point => [grouped(point.x), short(point.y)]), [0, 1]),
    config: () => ({type: 'line', data: {datasets: [{label: 'size', data: points, borderColor: colour('helps'), borderWidth: 1.8,
      pointRadius: 0, pointHitRadius: 6}]},
    options: {parsing: false, scales: {x: axis('step', {type: 'linear'}), y: axis('size of the gradient', {type: 'logarithmic'})},
      plugins: {tooltip: {callbacks: {title: items => 'step ' + grouped(items[0].parsed.x), label: item => short(item.parsed.y)}}}}}),
  });
}

// Fits the straight line that is nearest to the points in y.
function leastSquares(points) {
  const x = points.map(point => point.x), y = points.map(point => point.y), meanX = mean(x), meanY = mean(y);
  const slope = mean(x.map((value, i) => (value - meanX) * (y[i] - meanY))) / mean(x.map(value => (value - meanX) ** 2));
  return [Math.min(...x), Math.max(...x)].map(end => ({x: end, y: meanY + slope * (end - meanX)}));
}

function drawRetrainings({retrainings}, method) {
  const points = retrainings.means[method].map((value, i) => ({x: value, y: retrainings.measured[i],
    label: 'retraining ' + (i + 1) + ' on ' + plural(retrainings.photos[i], 'photo')})).filter(point => known(point.x) && known(point.y));
  if (!points.length) return emptyChart('retrainings-chart');
  const {r, rho} = correlations(points);
  return drawPredicted('retrainings-chart', {points, line: {label: 'least squares', data: leastSquares(points)},
    label: 'PSNR of retrainings against the mean ' + wordFor(method) + ' of their photos',
    across: 'mean ' + wordFor(method) + ' of its photos', up: 'validation PSNR of the retraining, dB',
    caption: plural(points.length, 'retraining') + ' on parts of the photos: r = ' + fixed(r, 2) +
      ', rho = ' + fixed(rho, 2) + (method === 'worth_psnr' ? '. Worth was fitted to these very retrainings.' : '.')});
}

// Draws the section, where there is something to compare with.
function fillTrust() {
  const one = run(), points = gatePoints(one);
  const methods = one.retrainings ? Object.keys(one.retrainings.means) : [], entries = methods.map(name => [name, wordFor(name)]);
  byId('trust').hidden = !points.length && !one.growth && !methods.length;
  if (byId('trust').hidden) return;
  byId('trust-note').textContent = !points.length ? '' : passesGate(one) ? 'Lasting credit predicts what retrainings measure here.' :
    'Lasting credit is not to be trusted here: it does not predict what retrainings measure.';
  const first = ['lasting_psnr', 'dv_psnr', 'worth_psnr'].find(name => methods.includes(name));
  byId('retrainings-filters').replaceChildren(...(first ? [selectBox('choose-retrainings', 'Score', entries, first,
    method => drawRetrainings(one, method))] : []));
  whenSeen('trust', () => {
    drawGate(one);
    drawGrowth(one);
    if (first) drawRetrainings(one, first); else emptyChart('retrainings-chart');
  });
}
