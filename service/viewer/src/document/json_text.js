// JSON text with positions: the characters of the value at a JSON pointer, and formatting that leaves every
// number as it was written.

const TOKEN = /\s+|"(?:[^"\\]|\\.)*"|-?\d[\d.eE+-]*|true|false|null|NaN|-?Infinity|[[\]{}:,]/y;

/** Tree of {kind, start, end, children: [{name, node}]}; null where the text is not JSON. */
export function parse(text) {
  const tokens = tokenise(text);
  if (!tokens) return null;
  let next = 0;

  function value() {
    const token = tokens[next++];
    if (!token) throw new SyntaxError("the text ends early");
    if (token.text === "{" || token.text === "[") return compound(token, token.text === "{");
    if (/^[\]}:,]$/.test(token.text)) throw new SyntaxError("a value is missing");
    return { kind: "scalar", start: token.start, end: token.end, text: token.text };
  }

  function compound(open, isObject) {
    const [close, children] = [isObject ? "}" : "]", []];
    while (tokens[next]?.text !== close) {
      if (children.length) expect(",");
      const key = isObject ? tokens[next++] : null;
      if (isObject) expect(":");
      children.push({ name: isObject ? JSON.parse(key.text) : String(children.length), key, node: value() });
    }
    const end = tokens[next++].end;
    return { kind: isObject ? "object" : "array", start: open.start, end, children };
  }

  function expect(text) {
    if (tokens[next++]?.text !== text) throw new SyntaxError(`${text} is missing`);
  }

  try {
    const tree = value();
    return next === tokens.length ? tree : null;
  } catch {
    return null;
  }
}

function tokenise(text) {
  const tokens = [];
  TOKEN.lastIndex = 0;
  while (TOKEN.lastIndex < text.length) {
    const start = TOKEN.lastIndex;
    const match = TOKEN.exec(text);
    if (!match) return null;
    if (match[0].trim()) tokens.push({ text: match[0], start, end: TOKEN.lastIndex });
  }
  return tokens;
}

/** Characters of the value at a pointer; of its nearest parent where it is missing. */
export function find(text, pointer) {
  let node = parse(text);
  if (!node) return null;
  let start = node.start;
  for (const part of pointer.split("/").slice(1)) {
    const name = part.replaceAll("~1", "/").replaceAll("~0", "~");
    // the last of duplicate names counts, as in JSON.parse
    const child = node.children?.findLast((each) => each.name === name);
    if (!child) return { start, end: node.kind === "scalar" ? node.end : start + 1, whole: false };
    node = child.node;
    start = child.key?.start ?? node.start;
  }
  return { start: node.start, end: node.end, whole: true };
}

const WIDTH = 46;

/** The formatted text: what fits stays on one line; text that is not JSON is returned unchanged. */
export function tidy(text) {
  const tree = parse(text);
  return tree ? formatted(tree, "") + "\n" : text;
}

function formatted(node, indent) {
  const flat = oneLine(node);
  if (!node.children?.length || (indent && indent.length + flat.length <= WIDTH)) return flat;
  const inner = indent + "  ";
  const lines = node.children.map((child) => inner + keyText(child) + formatted(child.node, inner));
  const [open, close] = node.kind === "object" ? "{}" : "[]";
  return `${open}\n${lines.join(",\n")}\n${indent}${close}`;
}

function oneLine(node) {
  if (!node.children) return node.text;
  const parts = node.children.map((child) => keyText(child) + oneLine(child.node)).join(", ");
  return node.kind === "object" ? `{${parts}}` : `[${parts}]`;
}

const keyText = (child) => (child.key ? `${child.key.text}: ` : "");

/** The edit {from, to, insert} that replaces or adds a member; null where its parent is no object. */
export function changeOf(text, pointer, value) {
  const node = nodeAt(text, pointer);
  if (node) return { from: node.start, to: node.end, insert: value };
  const [parent, name] = [pointer.slice(0, pointer.lastIndexOf("/")), pointer.slice(pointer.lastIndexOf("/") + 1)];
  const holder = nodeAt(text, parent);
  if (holder?.kind !== "object") return null;
  const end = holder.children.at(-1)?.node.end ?? holder.start + 1;
  return { from: end, to: end, insert: `${holder.children.length ? "," : ""}\n  ${JSON.stringify(name)}: ${value}` };
}

/** The text with another value of a member of the document. */
export function withMember(text, name, value) {
  const { from, to, insert } = changeOf(text, `/${name}`, value);
  return text.slice(0, from) + insert + text.slice(to);
}

function nodeAt(text, pointer) {
  const names = pointer.split("/").slice(1);
  return names.reduce((node, name) => node?.children?.findLast((child) => child.name === name)?.node ?? null, parse(text));
}
