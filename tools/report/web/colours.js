// Colours that people with any colour vision distinguish (Okabe and Ito 2008, a few made lighter or darker for contrast
// on either ground); beyond seven, dashes do. A body has one colour in the picture and in every plot.
const LIGHT = ['#5b6470', '#0072b2', '#d55e00', '#008c69', '#b4588f', '#3d97cc', '#b37700', '#8a6d3b'];
const DARK = ['#a7b0bc', '#4ba6e3', '#f08036', '#25bd93', '#de92bd', '#83c9f2', '#e8b03a', '#c9a66b'];
export const PALETTE = LIGHT.length;
const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3]];

export function isDark() {
  const wanted = document.documentElement.dataset.theme;
  return wanted ? wanted === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
}

export function colour(number) {
  const colours = isDark() ? DARK : LIGHT;
  return colours[number % colours.length];
}

// Of the second run: the same hue, halfway to the ink, so that the two differ without their dashes.
export function secondColour(number) {
  const [from, ink] = [colour(number), isDark() ? '#ffffff' : '#000000'];
  const part = (text, k) => parseInt(text.slice(1 + 2 * k, 3 + 2 * k), 16);
  return `#${[0, 1, 2].map((k) => Math.round(0.5 * part(from, k) + 0.5 * part(ink, k)).toString(16).padStart(2, '0')).join('')}`;
}

export function dash(number) { return DASHES[Math.floor(number / LIGHT.length) % DASHES.length]; }

export function css(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }
