; Written by lang/tests/editors.rs from tree-sitter-kinora/queries/highlights.scm.

(comment) @comment
((comment) @comment.line.documentation
  (#match? @comment.line.documentation "^///([^/]|$)"))

(string) @string
(escape) @constant.character.escape
(number) @constant.numeric
(unit) @type.builtin
(color) @constant
(boolean) @constant.builtin.boolean

(identifier) @variable

((identifier) @variable.builtin
  (#any-of? @variable.builtin
; begin always
"frame" "normal" "p" "p_local" "time" "uv"
; end always
  ))

(field name: (identifier) @variable.other.member)
(property name: (identifier) @variable.other.member)
(property name: (string) @variable.other.member)
(argument name: (identifier) @variable.other.member)

(node kind: (path (identifier) @type .))
(node name: (identifier) @label)
(node name: (string) @label)
(node "like" like: (path (identifier) @label .))

(type (identifier) @type)
(let name: (identifier) @variable)
(param name: (identifier) @variable.parameter)
(parameter name: (identifier) @variable.parameter)
(for name: (identifier) @variable)
(import name: (identifier) @namespace)
(function name: (identifier) @function)
(prefab name: (identifier) @type)

(call function: (path (identifier) @function .))
((call function: (path . (identifier) @function.builtin .))
  (#any-of? @function.builtin
; begin functions
"abs" "acos" "asin" "atan" "atan2" "axis_angle" "blackbody" "ceil" "cell" "cell_id" "checker"
"clamp" "cos" "count" "cross" "distance" "dot" "euler" "exp" "f_number" "face_towards" "fbm"
"floor" "fract" "hsv" "image" "length" "linear" "log" "look_at" "max" "min" "mix" "mod" "node"
"noise" "normal_map" "normalize" "oklch" "rand" "rotate_x" "rotate_y" "rotate_z" "round" "saturate"
"sign" "sin" "smoothstep" "sqrt" "srgb" "step" "sum" "tan" "turn"
; end functions
  ))

(key ease: (path (identifier) @constant))
((key ease: (call function: (path (identifier) @function.builtin)))
  (#any-of? @function.builtin
; begin curves
"bezier" "spring" "steps"
; end curves
  ))

[
  "let" "param" "prefab" "lang" "like" "keys" "ease" "after"
] @keyword
"fn" @keyword.function
"return" @keyword.control.return
["if" "else"] @keyword.control.conditional
["for" "in"] @keyword.control.repeat
["import" "from" "as"] @keyword.control.import


(binary operator: _ @operator)
(unary operator: _ @operator)
["=" "->"] @operator

["{" "}" "(" ")" "[" "]"] @punctuation.bracket
["," ";" ":" "."] @punctuation.delimiter
