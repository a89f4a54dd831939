; As nvim-treesitter reads them.
[
  (block)
  (key_block)
  (arm)
  (arguments)
  (parameters)
  (import_names)
  (list)
  (tuple)
] @indent.begin

["}" ")" "]"] @indent.branch @indent.end

(comment) @indent.ignore
