"use strict";

// Beside the bundle rather than in the page: a page without inline scripts can forbid them all.
SwaggerUIBundle({
  url: "openapi.json",
  dom_id: "#description",
  deepLinking: true,
  validatorUrl: null, // it would ask somebody else's server
});
