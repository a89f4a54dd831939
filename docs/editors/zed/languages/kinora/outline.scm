(node kind: (path) @context name: (_)? @name) @item
(prefab "prefab" @context name: (_) @name) @item
(function "fn" @context name: (_) @name) @item
(let "let" @context name: (_) @name) @item
(param "param" @context name: (_) @name) @item
