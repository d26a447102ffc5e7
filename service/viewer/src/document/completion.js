// Completion of keys and values in the document, from the OpenAPI schema of a scene.

import { syntaxTree } from "@codemirror/language";

/** A completion source for CodeMirror; `description` resolves to /openapi.json. */
export function completionsFrom(description) {
  let schemas = null;
  return async (context) => {
    const node = syntaxTree(context.state).resolveInner(context.pos, -1);
    const word = context.matchBefore(/"?[\w-]*/);
    if (!word || (word.from === word.to && !context.explicit)) return null;
    schemas ??= (await description()).components.schemas;
    const isKey = node.name === "PropertyName" || node.name === "Object" || node.parent?.name === "Object";
    const text = (at) => context.state.sliceDoc(at.from, at.to);
    const candidates = schemasAt(pathTo(node, text), schemas);
    const options = isKey && node.name !== "String" ? keys(candidates, schemas) : values(candidates, schemas);
    return options.length ? { from: word.from, options, validFor: /^"?[\w-]*$/ } : null;
  };
}

/** Keys and indices from the root to a node: ["orbit", "altitude"], ["effects", 0, "type"]. */
export function pathTo(node, text) {
  const path = [];
  for (let at = node; at.parent; at = at.parent) {
    if (at.name === "Property" && node.name !== "PropertyName") path.unshift(JSON.parse(text(at.firstChild)));
    else if (at.name === "Property" && at !== node.parent) path.unshift(JSON.parse(text(at.firstChild)));
    else if (at.parent.name === "Array") path.unshift(0);
  }
  return path;
}

/** All schemas that apply at a path, with every alternative. */
export function schemasAt(path, schemas) {
  let candidates = alternatives({ $ref: "#/components/schemas/Scene" }, schemas);
  for (const part of path) {
    candidates = candidates.flatMap((schema) => {
      const next = typeof part === "number" ? schema.items : schema.properties?.[part];
      return next ? alternatives(next, schemas) : [];
    });
  }
  return candidates;
}

function alternatives(schema, schemas) {
  if (schema.$ref) return alternatives(schemas[schema.$ref.split("/").at(-1)], schemas);
  const parts = [...(schema.anyOf ?? []), ...(schema.oneOf ?? []), ...(schema.allOf ?? [])];
  return parts.length ? parts.flatMap((part) => alternatives(part, schemas)) : [schema];
}

function keys(candidates) {
  const options = new Map();
  for (const { properties = {}, required = [] } of candidates) {
    for (const [name, schema] of Object.entries(properties)) {
      const detail = required.includes(name) ? "required" : "";
      options.set(name, { label: `"${name}"`, detail, info: schema.description, apply: `"${name}": ` });
    }
  }
  return [...options.values()];
}

function values(candidates) {
  const words = candidates.flatMap(({ enum: words = [], const: word, examples = [] }) => [...words, ...(word === undefined ? [] : [word]), ...examples]);
  return [...new Set(words)].map((word) => ({ label: JSON.stringify(word) }));
}
