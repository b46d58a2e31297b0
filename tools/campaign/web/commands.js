// Commands that fly a sample again.
import { data } from '../../pages/web/elements.js';

const { summary, manifest } = data;
const quote = (text) => (/^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`);  // for a shell
const optionsOf = (sample) => [...(summary.rare && sample >= summary.rare.samples ? ['--results', data.folder] : []), ...manifest.set.flatMap((text) => ['--set', text])].map((text) => ` ${quote(text)}`).join('');
export const command = (sample) => `unlatch run ${quote(manifest.campaign_file)} --sample ${sample}${optionsOf(sample)} --log ${sample}.log; unlatch report ${sample}.log --out ${sample}.html`;
