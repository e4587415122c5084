'use strict';
// Places for the next photos: on the map, and in a table. Only pages that have some have this script.

const PLACE_PX = 18, PLACE_OPENING = .45; // length of a pyramid, and its half width as a share of that
const PLACE_COLOUR = PALETTE[3];
const EXTENT_MOST = 3; // by that of cameras and points; farther places are drawn at the edge
const UPWARD = {'map-above': 'across', 'map-side': 'up'}; // the upward axis, by the id of a map
const upwardOf = chart => UPWARD[chart.canvas.closest('[id]')?.id];

// Places the proposals of a run along the axes of its map.
function placesOf(one) {
  if (!one.next || !layoutOf(one)) return [];
  const positions = Array.from({length: one.map.positions.length / 3}, (_, i) => triple(one.map.positions, i));
  const axes = axesOf(one.map, positions.filter(p => p.every(known)));
  const along = p => ({level: dot(p, axes.level), across: dot(p, axes.across), up: dot(p, axes.up)});
  return one.next.proposals.map(({position, direction}) => ({at: along(position), to: along(direction)}));
}

// Draws an open pyramid with its number.
function drawPlace(pen, number, [x, y], [toX, toY]) {
  const corner = side => [x + PLACE_PX * (toX - side * PLACE_OPENING * toY), y - PLACE_PX * (toY + side * PLACE_OPENING * toX)];
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(...corner(1));
  pen.lineTo(...corner(-1));
  pen.closePath();
  Object.assign(pen, {strokeStyle: PLACE_COLOUR, lineWidth: 2});
  pen.stroke();
  Object.assign(pen, {strokeStyle: colour('page'), fillStyle: PLACE_COLOUR, lineWidth: 3, textAlign: 'center', textBaseline: 'middle'});
  pen.strokeText(number, x - 9 * toX, y + 9 * toY);
  pen.fillText(number, x - 9 * toX, y + 9 * toY);
}

// Makes the places points without a mark, which have a tooltip.
function addTooltips({data, options}, places, y) {
  const {tooltip} = options.plugins, {filter, callbacks: {label}} = tooltip, {proposals} = run().next;
  data.datasets.push({label: 'places', data: places.map(({at}, place) => ({x: at.level, y: at[y], place})), pointStyle: 'circle',
    radius: 9, borderWidth: 0, backgroundColor: 'transparent', hoverBackgroundColor: 'transparent'});
  tooltip.filter = item => item.raw.place !== undefined || filter(item);
  tooltip.callbacks.label = item => item.raw.place === undefined ? label(item) :
    [[item.raw.place + 1, proposals[item.raw.place].reason].filter(Boolean).join(': '), proposals[item.raw.place].move];
}

Chart.register({id: 'places', beforeInit(chart) { // the map grows until all places are on it
  const places = placesOf(run()), {scales} = chart.config.options, y = upwardOf(chart);
  if (!y || !places.length) return;
  const {middle, half} = layoutOf(run()), reach = axis => Math.max(...places.map(({at}) => Math.abs(at[axis] - middle[axis])));
  const wide = Math.min(EXTENT_MOST * half, Math.max(half, 1.08 * Math.max(...['level', 'across', 'up'].map(reach))));
  Object.assign(scales.x, {min: middle.level - wide, max: middle.level + wide});
  Object.assign(scales.y, {min: middle[y] - wide, max: middle[y] + wide});
  addTooltips(chart.config, places, y);
}, afterDatasetsDraw(chart) {
  const pen = chart.ctx, {x, y} = chart.scales, {left, right, top, bottom} = chart.chartArea, up = upwardOf(chart);
  const within = (pixel, least, most) => Math.min(Math.max(pixel, least), most);
  if (!up) return;
  pen.save();
  pen.font = 'bold 12px sans-serif';
  placesOf(run()).forEach(({at, to}, i) =>
    drawPlace(pen, String(i + 1), [within(x.getPixelForValue(at.level), left, right), within(y.getPixelForValue(at[up]), top, bottom)],
      [to.level, to[up]]));
  pen.restore();
}});

function placesTable({next: {proposals, pictures = []}}) {
  const seen = pictures.length ? 1 : 0; // a column of renders, unless photos are left out
  const render = i => pictures[i] ? element('img', {src: pictureUri('webp', pictures[i]), height: 104, loading: 'lazy',
    alt: 'render from place ' + (i + 1)}) : '';
  return plainTable(['', ...(seen ? ['render'] : []), 'why', 'distance', 'photos that see it', 'from the nearest photo'],
    proposals.map((place, i) => [String(i + 1), ...(seen ? [render(i)] : []), place.reason, short(place.distance),
      short(place.seen_by), place.move]), [0, 2 + seen, 3 + seen]);
}

function showPlaces() {
  const planned = runs.filter(one => one.next && one.next.proposals.length);
  if (!planned.length) return;
  byId('distribution').before(element('section', {id: 'next'}, element('h2', {}, 'Places for the next photos'),
    element('p', {class: 'quiet'}, 'Proposed by viewworth next, in this order: numbered pyramids on the map. A distance, also of a step, ' +
      'of 1 is usual between neighbouring photos. The photos that see it are the median over what a photo from there would show.'),
    ...planned.flatMap(one => [...(runs.length > 1 ? [element('h3', {}, nameOfRun(one))] : []), placesTable(one)])));
  redrawCharts(); // some are older than this script
}
showPlaces();
