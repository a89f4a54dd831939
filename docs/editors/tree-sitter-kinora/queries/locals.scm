(source_file) @local.scope
(block) @local.scope
(function) @local.scope
(prefab) @local.scope
(for) @local.scope
(comprehension) @local.scope

(let name: (identifier) @local.definition)
(param name: (identifier) @local.definition)
(parameter name: (identifier) @local.definition)
(for name: (identifier) @local.definition)
(comprehension name: (identifier) @local.definition)
(function name: (identifier) @local.definition)
(prefab name: (identifier) @local.definition)
(import name: (identifier) @local.definition)
(node name: (identifier) @local.definition)

(path . (identifier) @local.reference)
