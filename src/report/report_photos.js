'use strict';
// The map of cameras, the panel of one photo, and photos beside their renders.

// ---- Colours of scores --------------------------------------------------------------------------------------------------

const CIVIDIS = [[0, 34, 78], [66, 78, 108], [124, 123, 120], [187, 173, 108], [254, 232, 56]]; // legible with any colour vision
const DIVERGING = [[213, 94, 0], [236, 170, 120], [245, 245, 245], [122, 180, 214], [0, 114, 178]];

function mixed(stops, place) {
  const at = Math.min(1, Math.max(0, place)) * (stops.length - 1), first = Math.min(stops.length - 2, Math.floor(at));
  return 'rgb(' + stops[first].map((part, c) => Math.round(part + (stops[first + 1][c] - part) * (at - first))).join(',') + ')';
}

// Returns the scale of colours, around zero where scores have one. One outlier would make all others alike: full colour stands at the
// 98th percentile.
function scoreColours(rows) {
  const values = rows.map(row => row.value).filter(known).sort((a, b) => a - b), diverging = hasZero();
  const at = share => values[Math.round(share * (values.length - 1))] ?? 0;
  const largest = Math.max(Math.abs(at(.02)), Math.abs(at(.98))) || 1;
  const low = diverging ? -largest : at(.02), high = diverging ? largest : at(.98) > low ? at(.98) : low + 1;
  const stops = diverging ? DIVERGING : CIVIDIS;
  return {low, high, diverging, stops, of: value => known(value) ? mixed(stops, (value - low) / (high - low)) : 'transparent'};
}

function colourLegend(colours) {
  const decimals = decimalsFor([colours.low, colours.high]), ramp = element('span', {class: 'ramp'});
  ramp.style.background = 'linear-gradient(to right, ' + colours.stops.map(stop => 'rgb(' + stop.join(',') + ')').join(', ') + ')';
  return element('p', {class: 'colours'}, chosen.method + ', ' + shortUnit(unitOf(run())) + ': ', fixed(colours.low, decimals), ramp,
    fixed(colours.high, decimals), colours.diverging ? ' (white: 0)' : ' (yellow: higher)');
}

// ---- Map ----------------------------------------------------------------------------------------------------------------

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const triple = (list, i) => list.slice(3 * i, 3 * i + 3);
function unit(a) { const length = Math.sqrt(dot(a, a)); return a.map(part => part / length); }

// Finds up and two level directions: the first is that along which the cameras spread most, so that the side view is wide.
function axesOf(map, positions) {
  const up = unit(map.up), a = unit(cross(up, Math.abs(up[0]) < .8 ? [1, 0, 0] : [0, 1, 0])), b = cross(up, a);
  const along = positions.map(p => [dot(p, a), dot(p, b)]), middle = [0, 1].map(c => mean(along.map(p => p[c])));
  let aa = 0, ab = 0, bb = 0;
  for (const [x, y] of along) { aa += (x - middle[0]) ** 2; ab += (x - middle[0]) * (y - middle[1]); bb += (y - middle[1]) ** 2; }
  const angle = Math.atan2(2 * ab, aa - bb) / 2, level = a.map((part, c) => Math.cos(angle) * part + Math.sin(angle) * b[c]);
  return {up, level, across: cross(up, level)};
}

function rangeOf(values, share) {
  const sorted = values.filter(known).sort((a, b) => a - b), place = part => sorted[Math.round(part * (sorted.length - 1))];
  return sorted.length ? [place(share), place(1 - share)] : [];
}

// Places cameras and points along three axes, in a square that holds all cameras and nearly all points; null where none is known.
function makeLayout({map}) {
  if (!map) return null;
  const cut = list => Array.from({length: Math.floor(list.length / 3)}, (_, i) => triple(list, i));
  const positions = cut(map.positions), axes = axesOf(map, positions.filter(p => p.every(known)));
  const seen = list => list.map(p => ({level: dot(p, axes.level), across: dot(p, axes.across), up: dot(p, axes.up)}));
  const layout = {cameras: seen(positions), directions: seen(cut(map.directions)), points: seen(cut(map.points)), middle: {}, half: 0};
  for (const axis of ['level', 'across', 'up']) {
    const ends = [...rangeOf(layout.cameras.map(p => p[axis]), 0), ...rangeOf(layout.points.map(p => p[axis]), .03)];
    layout.middle[axis] = (Math.min(...ends) + Math.max(...ends)) / 2;
    layout.half = Math.max(layout.half, (Math.max(...ends) - Math.min(...ends)) / 2);
  }
  layout.half = 1.08 * (layout.half || 1);
  return known(layout.half) && Object.values(layout.middle).every(known) ? layout : null;
}

const layouts = new Map(); // by run
function layoutOf(one) {
  if (!layouts.has(one)) layouts.set(one, makeLayout(one));
  return layouts.get(one);
}

const CAMERA_KINDS = [['train', 'photos to train on', 'circle'], ['val', 'validation photos', 'rect'], ['test', 'test photos', 'triangle']];
const TICK_PX = 12;

// Draws the direction in which each camera looks, and a ring around the chosen one.
function cameraMarks(layout, x, y) {
  return {id: 'cameras', beforeDatasetsDraw(chart) {
    const pen = chart.ctx, {scales} = chart;
    pen.save();
    pen.strokeStyle = colour('quiet');
    pen.lineWidth = 1;
    pen.beginPath();
    layout.cameras.forEach((p, i) => {
      const from = [scales.x.getPixelForValue(p[x]), scales.y.getPixelForValue(p[y])], to = layout.directions[i];
      if (!known(from[0]) || !known(from[1]) || run().images.split[i] === 'excluded') return;
      pen.moveTo(...from);
      pen.lineTo(from[0] + TICK_PX * to[x], from[1] - TICK_PX * to[y]);
    });
    pen.stroke();
    pen.restore();
  }, afterDatasetsDraw(chart) {
    const pen = chart.ctx, p = layout.cameras[chosen.photo];
    if (!p) return;
    pen.save();
    pen.strokeStyle = colour('ink');
    pen.lineWidth = 2.5;
    pen.beginPath();
    pen.arc(chart.scales.x.getPixelForValue(p[x]), chart.scales.y.getPixelForValue(p[y]), 10, 0, 2 * Math.PI);
    pen.stroke();
    pen.restore();
  }};
}

function drawMapView(id, title, layout, rows, colours, y) {
  const x = 'level', radius = byId(id).clientWidth < 300 ? 3.5 : 5, byImage = new Map(rows.map(row => [row.image, row])), {images} = run();
  const {half, middle} = layout, scale = axis => ({type: 'linear', display: false, min: middle[axis] - half, max: middle[axis] + half});
  const places = split => layout.cameras.map((p, image) => ({x: p[x], y: p[y], image}))
    .filter(point => images.split[point.image] === split && known(point.x) && known(point.y));
  const kinds = CAMERA_KINDS.map(([split, label, pointStyle]) => ({label, pointStyle, radius, hoverRadius: 8, data: places(split)}))
    .filter(set => set.data.length);
  const listed = () => rows.filter(row => row.split !== 'excluded').map(row => [row.name, row.split, short(row.value),
    ...[x, y].map(axis => short(layout.cameras[row.image][axis] - middle[axis]))]);
  drawChart(id, {shape: 'map', label: 'Cameras ' + title, caption: title[0].toUpperCase() + title.slice(1),
    behind: tableBehind('Table of the cameras', ['photo', 'split', chosen.method, 'to the right', 'up'], listed, [2, 3, 4]),
    config: () => ({type: 'scatter', plugins: [cameraMarks(layout, x, y)], data: {datasets: [
      ...kinds.map(set => ({...set, borderColor: colour('ink'), borderWidth: 1,
        backgroundColor: set.data.map(point => colours.of(byImage.get(point.image).value))})),
      {label: 'points of the scene', data: layout.points.map(p => ({x: p[x], y: p[y]})), pointStyle: 'circle', radius: 1.2, hitRadius: 0,
        hoverRadius: 1.2, borderWidth: 0, backgroundColor: colour('quiet') + '90'}]},
    options: {layout: {padding: 12}, scales: {x: scale(x), y: scale(y)}, onClick: (event, items) => {
      const item = items.find(one => one.datasetIndex < kinds.length);
      if (item) choosePhoto(run(), kinds[item.datasetIndex].data[item.index].image);
    }, plugins: {legend: {display: false}, tooltip: {filter: item => item.raw.image !== undefined,
      callbacks: {label: item => toldPhoto(byImage.get(item.raw.image))}}}}}),
  });
}

// Makes a line of a photo with its score and rank.
function toldPhoto(row) {
  const scored = known(row.value) ? signed(row.value, decimalsFor([row.value])) + ' ' + shortUnit(unitOf(run())) +
    (known(row.rank) ? ', rank ' + row.rank : '') : 'no score';
  return row.name + ' (' + row.split + '): ' + scored;
}

function drawMap() {
  const layout = layoutOf(run()), rows = photoRows(run()), colours = scoreColours(rows);
  byId('map-legend').replaceChildren(colourLegend(colours));
  drawMapView('map-above', 'from above', layout, rows, colours, 'across');
  drawMapView('map-side', 'from the side', layout, rows, colours, 'up');
  tellChosen();
}

function tellChosen() {
  const row = photoRows(run()).find(one => one.image === chosen.photo);
  byId('map-chosen').textContent = row ? 'Chosen: ' + toldPhoto(row) : '';
}

function fillMap() {
  byId('map').hidden = !layoutOf(run());
  if (layoutOf(run())) whenSeen('map', drawMap);
}

// Lets the arrow keys go through the photos in the order of the ranking.
function stepThroughPhotos(event) {
  const step = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key];
  if (event.key === 'Enter') return choosePhoto(run(), chosen.photo);
  if (!step) return undefined;
  event.preventDefault();
  const rows = photoRows(run()).filter(row => row.split !== 'excluded'), place = rows.findIndex(row => row.image === chosen.photo);
  return choosePhoto(run(), rows[(place + step + rows.length) % rows.length].image, false);
}

// ---- One photo ----------------------------------------------------------------------------------------------------------

function choosePhoto(one, image, goes = true) {
  if (one !== run()) chooseRun(runs.indexOf(one));
  chosen.photo = image;
  fillPhoto();
  for (const id of ['map-above', 'map-side']) if (charts.has(id)) charts.get(id).chart.draw();
  if (layoutOf(run())) tellChosen();
  if (!goes) return;
  drawNow('photo');
  byId('photo').scrollIntoView();
  byId('photo-name').focus({preventScroll: true});
}

// Tells how bright a photo shows mid-grey beside the median photo, where a run has corrected it; null: it has not.
function exposureOf(one, name) {
  const effect = (Array.isArray(one.effects) ? one.effects : []).find(other => other.name === 'appearance');
  const numbers = effect && effect.on && effect.exposures ? effect.exposures[sharedFolder + name] : null;
  if (!Array.isArray(numbers) || numbers.length !== 6 || !numbers.every(known) || !numbers.some(Boolean)) return null;
  return fixed(1 + mean(numbers.slice(0, 3)) + 2 * mean(numbers.slice(3)), 2) + ' times as bright as the median photo, and corrected';
}

function photoFacts(one, image) {
  const {split, provider, ground_truth: truth} = one.images, name = one.images.name[image], facts = [['split', split[image]]];
  const groups = tablesNamed('duplicates.csv').filter(table => table.label === one.label).flatMap(recordsOf)
    .map(row => ({...row, name: withoutFolder(row.name)}));
  const own = groups.find(row => row.name === name), alike = own ? groups.filter(row => row.group === own.group && row.name !== name) : [];
  if (sharedFolder) facts.push(['folder', sharedFolder]);
  if (provider[image]) facts.push(['provider', provider[image]]);
  if (truth[image]) facts.push(['ground truth', truth[image] === 'clean' ? 'clean' : 'corrupted on purpose: ' + truth[image]]);
  facts.push(['near-duplicates', alike.map(row => row.name + (row.provider ? ' (' + row.provider + ')' : '')).join(', ') || 'none found']);
  const exposure = exposureOf(one, name);
  if (exposure) facts.push(['exposure', exposure]);
  const advised = adviceOf(one, image);
  if (advised) facts.push(['advice', advised]);
  return plainTable(['', ''], facts.map(([title, text]) => [element('th', {scope: 'row'}, title), element('td', {class: 'long'}, text)]));
}

function photoScores(one, image) {
  const lines = methodsOf(one).map(({name, unit: of}) => {
    const rows = photoRows(one, name), row = rows.find(other => other.image === image);
    const decimals = decimalsFor(rows.map(other => other.value));
    if (!row || !known(row.value)) return null;
    return [wordFor(name), signed(row.value, decimals) + ' ' + shortUnit(of),
      known(row.ci_low) ? signed(row.ci_low, decimals) + ' to ' + signed(row.ci_high, decimals) : '–',
      known(row.rank) ? String(row.rank) : '–',
      row.rankLow ? row.rankLow + '–' + row.rankHigh : '–'];
  }).filter(Boolean);
  if (!lines.length) return element('p', {class: 'quiet'}, 'Photos that are not trained on have no score.');
  return plainTable(['score', 'value', '95 % interval', 'rank', 'rank interval'], lines, [1, 2, 3, 4]);
}

// Tells how the photo's steps changed each validation photo; for a validation photo, which photos changed it.
function photoMoved(one, image) {
  const {matrix} = one, row = matrix ? matrix.photo.indexOf(image) : -1, column = matrix ? matrix.view.indexOf(image) : -1;
  if (row < 0 && column < 0) return null;
  const all = row >= 0 ? matrix.view.map((view, i) => [view, matrix.psnr[row][i]]) :
    matrix.photo.map((photo, i) => [photo, matrix.psnr[i][column]]);
  const most = all.filter(([other, value]) => known(value) && other !== null).sort((a, b) => Math.abs(b[1]) - Math.abs(a[1])).slice(0, 6);
  const decimals = decimalsFor(most.map(([, value]) => value));
  return element('div', {}, element('h3', {}, row >= 0 ? 'Validation photos that it moved most' : 'Photos that moved it most'),
    plainTable(['photo', 'PSNR moved, dB'], most.map(([other, value]) => [photoCell(one, other),
      element('span', {class: value < 0 ? 'harms' : undefined}, signed(value, decimals))]), [1]));
}

function pictureUri(format, base64) { return 'data:image/' + format + ';base64,' + base64; }

// Shows the photo of a stored picture, and its render beside it, without the error. A click opens the photo.
function pairOf(one, photo) {
  const half = (text, kind) => {
    const image = element('img', {src: pictureUri('webp', photo.picture), alt: text + ' of ' + one.images.name[photo.image]});
    const button = element('button', {type: 'button', class: 'pane ' + kind}, image, element('span', {}, text));
    image.addEventListener('load', () => button.style.setProperty('--ratio', image.naturalWidth / 3 / image.naturalHeight));
    button.addEventListener('click', () => choosePhoto(one, photo.image));
    return button;
  };
  return [half('photo', 'first'), half('render', 'second')];
}

// Shows the validation photo in the middle by PSNR, which stands for the reconstruction.
function fillPair() {
  const one = run(), photos = (one.residuals ? one.residuals.photos : [])
    .filter(photo => one.images.split[photo.image] === 'val' && known(photo.psnr)).sort((a, b) => a.psnr - b.psnr);
  byId('pair').hidden = !photos.length;
  if (photos.length) byId('pair').replaceChildren(...pairOf(one, photos[Math.floor(photos.length / 2)]));
}

const NEAREST = 6;

// Shows the photos whose cameras are nearest.
function nearestPhotos(one, image) {
  const {map} = one, at = i => triple(map.positions, i), own = map ? at(image) : [];
  if (!own.length || !own.every(known)) return null;
  const away = other => { const step = at(other).map((part, c) => part - own[c]); return dot(step, step); };
  const near = one.images.name.map((_, i) => i).filter(i => i !== image && one.images.split[i] !== 'excluded' && at(i).every(known))
    .map(i => [away(i), i]).sort((a, b) => a[0] - b[0]).slice(0, NEAREST);
  return element('div', {}, element('h3', {}, 'Nearest photos'),
    element('div', {class: 'nearest'}, ...near.map(([, other]) => photoCell(one, other, [one.images.split[other]]))));
}

function residualFigure(one, photo) {
  const name = one.images.name[photo.image], told = name + (known(photo.psnr) ? ': ' + fixed(photo.psnr, 2) + ' dB' : '');
  return element('figure', {class: 'residual'},
    element('div', {class: 'captions'}, ...['photo', 'render', 'error'].map(text => element('span', {}, text))),
    element('img', {src: pictureUri('webp', photo.picture), alt: 'photo, render and error of ' + name, loading: 'lazy'}),
    element('figcaption', {}, told));
}

function photoResidual(one, image) {
  const photo = one.residuals ? one.residuals.photos.find(other => other.image === image) : null;
  const missing = 'No render of it is stored: viewworth render makes one.';
  return element('div', {}, element('h3', {}, 'What the field makes of it'), photo ? residualFigure(one, photo) :
    element('p', {class: 'quiet'}, missing));
}

// Draws bars by epoch and their running sum.
function drawCredit(one, image) {
  const {credit} = one, row = credit ? credit.rows[image] : null;
  emptyChart('photo-credit');
  if (!row) return;
  let total = 0;
  const parts = row.map(count => count * credit.unit), sums = parts.map(part => { total += part; return total; });
  const decimals = decimalsFor(sums), step = credit.group_epochs, labels = parts.map((_, i) => String(credit.first_epoch + i * step + 1));
  drawChart('photo-credit', {
    label: 'Credit of ' + one.images.name[image] + ' by epoch',
    caption: 'Credit of each ' + (step > 1 ? step + ' epochs' : 'visit') + ', and their sum: ' + signed(total, decimals) + ' dB.',
    behind: tableBehind('Table of the visits', ['epoch', 'credit, dB', 'sum, dB'],
      () => parts.map((part, i) => [labels[i], signed(part, decimals + 1), signed(sums[i], decimals + 1)]), [0, 1, 2]),
    config: () => ({type: 'bar', data: {labels, datasets: [
      {type: 'line', label: 'sum', data: sums, borderColor: colour('ink'), borderWidth: 1.8, borderDash: [6, 3], pointRadius: 0,
        pointStyle: 'line'},
      {label: 'credit of the visit', data: parts, pointStyle: 'rect', borderWidth: 1,
        backgroundColor: parts.map(part => part < 0 ? hatched('harms') : colour('helps')),
        borderColor: parts.map(part => colour(part < 0 ? 'harms' : 'helps'))}]},
    options: {interaction: {mode: 'index', intersect: false}, scales: {x: axis('epoch'), y: axis('validation PSNR, dB')},
      plugins: {tooltip: {callbacks: {title: items => 'epoch ' + items[0].label,
        label: item => item.dataset.label + ': ' + signed(item.parsed.y, decimals + 1) + ' dB'}}}}}),
  });
}

function drawPhoto() {
  const one = run(), image = chosen.photo;
  byId('photo-name').textContent = one.images.name[image];
  byId('choose-photo').value = String(image);
  byId('photo-facts').replaceChildren(element('div', {class: 'portrait'}, thumbnailOf(one, image)), photoFacts(one, image));
  byId('photo-scores').replaceChildren(photoScores(one, image));
  byId('photo-more').replaceChildren(...[photoResidual(one, image), photoMoved(one, image), nearestPhotos(one, image)].filter(Boolean));
  drawCredit(one, image);
}

// Shows one photo, which stays as long as the run does: first the one with the lowest score.
function fillPhoto() {
  const ranked = photoRows(run()).filter(row => known(row.value));
  byId('photo').hidden = !run().images.name;
  if (!run().images.name) return;
  if (chosen.photo === null) chosen.photo = ranked.length ? ranked[ranked.length - 1].image : 0;
  whenSeen('photo', drawPhoto);
}

function fillPhotoChoice() {
  const names = (run().images.name || []).map((name, image) => [String(image), name]).sort((a, b) => collator.compare(a[1], b[1]));
  byId('photo-filters').replaceChildren(selectBox('choose-photo', 'Photo', names, String(chosen.photo), value =>
    choosePhoto(run(), Number(value), false)));
}

// ---- Validation photos beside their renders -----------------------------------------------------------------------------

function fillResiduals() {
  const one = run(), photos = (one.residuals ? one.residuals.photos : []).filter(photo => one.images.split[photo.image] === 'val');
  byId('residuals').hidden = !photos.length;
  if (!photos.length) return;
  whenSeen('residuals', () => byId('residuals-list').replaceChildren(...[...photos].sort((a, b) => compareKeys(a.psnr, b.psnr) || 0)
    .map(photo => residualFigure(one, photo))));
}
