//@ implements mesh_tree when siblings
//@ use bind/nodes
// Trees of meshes in which the children of a node stand beside each other: nodes, and pairs of faces in place of nodes. A walk knows where a child is
// without reading its code, and reads it before it knows what it is. The tree of the scene has codes.

alias Visited = Node;

// The code of a primitive reads an element that nobody uses.
fn visit(code: u32) -> Visited {
    return nodes[select(code, 0u, (code & PRIMITIVE_BIT) != 0u)];
}

// The first word of a pair that is not a coordinate is the code of a face. That of a node has no highest bit.
fn visited_code(code: u32, visited: Visited) -> u32 {
    return select(code, visited.grid.w, ((visited.grid.w & ~code) & PRIMITIVE_BIT) != 0u);
}

fn visited_node(visited: Visited) -> Node {
    return visited;
}

fn visited_pair(visited: Visited) -> FacePair {
    return FacePair(visited.grid, vec4<u32>(visited.low, visited.padding0), vec4<u32>(visited.high, visited.padding1), visited.children);
}

fn children_of(code: u32, visited: Visited, in_mesh: bool) -> u32 {
    return select(code, visited.children.x, in_mesh);
}

fn child_code(children: u32, number: u32, in_mesh: bool) -> u32 {
    if in_mesh {
        return children + number;
    }
    return nodes[children].children[number];
}
